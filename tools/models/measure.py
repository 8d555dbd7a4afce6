"""What can be measured of a model anywhere, without the data it was made from: parity, speed, memory, size.

The same function fills a manifest's ``measured`` when a model is made and checks it for ``vlpg models verify``.
"""

import numpy as np

from edge.bench.probe_process import ProbeProcess
from edge.perception.encoder import Encoder
from models.manifest import Manifest
from tools.models.reference import Reference, parity

PASSES = 60  # timed


def measure(manifest: Manifest) -> dict[str, float]:
    """Figures by name; each tower runs alone in a fresh process, on one thread.

    ``image_parity``, ``image_parity_min``, ``text_parity``: cosines to float32, where the model has a reference;
    ``image_memory``: peak PSS [MB] of a process with numpy, ONNX Runtime and the image tower; ``encoder_memory``:
    the same with OpenCV and preprocessing; ``text_memory``: of one with tokenizer and text tower;
    ``image_p50``, ``image_p95``, ``text_p50``, ``text_p95``: duration [ms] of a pass; ``size``: of all files [MB].

    Raises:
        ModelError: its reference cannot be read.
        ProbeFailed: a tower does not run.
    """
    figures = {}
    reference = Reference.load(manifest.folder)
    if reference is not None:
        figures |= parity(Encoder(manifest), reference)
    for tower in ("image", "encoder", "text"):
        with ProbeProcess("tools.models.probe", tower, str(manifest.folder)) as probe:
            figures[f"{tower}_memory"] = round(probe.peak.pss, 1)
            times = 1e3 * np.array(probe.time(PASSES))
        if tower != "encoder":
            figures |= {f"{tower}_p{q}": round(float(np.percentile(times, q)), 2) for q in (50, 95)}
    figures["size"] = round(sum(file.size for file in manifest.files) / 1e6, 2)
    return figures
