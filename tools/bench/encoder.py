"""``vlpg bench encoder``: speed and memory of the image tower on one thread, beside what one would otherwise pick.

The same tower in float32 with PyTorch (extra ``train``), and in float32 with ONNX Runtime (package ``onnx``), each if
installed. Every tower has a process of its own. First each is weighed, alone; then all are timed in turns, a few passes
at a time, so that whatever else the machine does meets them alike.
"""

import argparse
import importlib.util
import json
import tempfile
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from models.manifest import DEFAULT, Manifest, ModelError, resolve
from tools.models.probe_process import ProbeFailed, ProbeProcess

OURS = "int8, ONNX Runtime, as on the robot"
PASSES = 3  # a turn; one more runs before them untimed, as the tower before has filled the caches
TURNS = 30


@dataclass(frozen=True)
class Peer:
    """What one tower took: times [ms], how many times ours it took, and its peak PSS [MB] and parts of it."""

    name: str
    p50: float
    p10: float
    p90: float
    ratio: float
    peak: float
    anonymous: float
    file_backed: float


def peers(manifest: Manifest, folder: Path) -> tuple[dict[str, tuple[str, ...]], list[str]]:
    """Command of each tower that can run here, ours first, and a sentence on each that cannot.

    ``folder`` gets the float32 graph.
    """
    size = (str(manifest.image.height), str(manifest.image.width))
    commands, missing = {OURS: ("tools.models.probe", "image", str(manifest.folder))}, []
    if importlib.util.find_spec("onnx"):
        from tools.bench.float_graph import dequantize

        graph = folder / "float32.onnx"
        dequantize(manifest.folder / manifest.image.graph, graph)
        commands["float32, ONNX Runtime"] = ("tools.bench.peer", "onnx", str(graph), *size)
    else:
        missing.append("float32 with ONNX Runtime is left out: it needs the package onnx (pip install onnx).")
    if manifest.name != DEFAULT:
        missing.append(f"float32 with PyTorch is left out: its code is here for {DEFAULT} only.")
    elif all(importlib.util.find_spec(name) for name in ("torch", "efficientnet_lite_pytorch")):
        commands["float32, PyTorch"] = ("tools.bench.peer", "torch", *size)
    else:
        missing.append("float32 with PyTorch is left out: it needs the extra train (pip install '.[train]').")
    return commands, missing


def measure(commands: dict[str, tuple[str, ...]], turns: int = TURNS) -> list[Peer]:
    """Weigh each alone, then time all in turns. Raises ProbeFailed when one does not run."""
    memory = {}
    for name, command in commands.items():
        with ProbeProcess(*command) as probe:
            memory[name] = probe.peak
    times: dict[str, list[list[float]]] = {name: [] for name in commands}
    with ExitStack() as stack:
        probes = {name: stack.enter_context(ProbeProcess(*command)) for name, command in commands.items()}
        for _ in range(turns):
            for name, probe in probes.items():
                times[name].append(probe.time(PASSES + 1)[1:])
    milliseconds = {name: 1e3 * np.array(turns) for name, turns in times.items()}
    per_turn = {name: np.median(values, 1) for name, values in milliseconds.items()}
    first = per_turn[next(iter(commands))]
    found = []
    for name, values in milliseconds.items():
        p10, p50, p90 = np.percentile(values, [10, 50, 90])
        # In pairs, turn by turn: the load of the machine changes between turns, less so within one.
        ratio = float(np.median(per_turn[name] / first))
        peak = memory[name]
        figures = (p50, p10, p90, ratio, peak.pss, peak.anonymous, peak.file_backed)
        found.append(Peer(name, *(round(float(figure), 2) for figure in figures)))
    return found


def show(found: list[Peer]) -> None:
    """Print the table."""
    print(f"{'one thread':36} {'p50':>7} {'p10 - p90':>15} {'x ours':>7} {'peak PSS':>9} {'anon + file':>12}")
    for peer in found:
        spread, parts = f"{peer.p10:.1f} - {peer.p90:.1f}", f"{peer.anonymous:.0f} + {peer.file_backed:.0f}"
        print(
            f"{peer.name:36} {peer.p50:4.1f} ms {spread:>12} ms {peer.ratio:6.2f}x {peer.peak:6.1f} MB {parts:>9} MB"
        )


def main(arguments: list[str] | None = None) -> None:
    """``vlpg bench encoder``."""
    parser = argparse.ArgumentParser(prog="vlpg bench encoder", description=__doc__.split(": ", 1)[1])
    parser.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    parser.add_argument("--turns", type=int, default=TURNS, help=f"of {PASSES} timed passes (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    options = parser.parse_args(arguments)
    if options.turns < 1:
        parser.error("--turns must be at least 1")
    try:
        manifest = Manifest.load(resolve(options.model))
        manifest.verify()
        with tempfile.TemporaryDirectory() as folder:
            commands, missing = peers(manifest, Path(folder))
            found = measure(commands, options.turns)
    except (ModelError, ProbeFailed) as error:
        parser.exit(2, f"vlpg bench encoder: {error}\n")
    print(f"{manifest.name}, {manifest.image.height} x {manifest.image.width} px, {options.turns} turns")
    show(found)
    print("\n".join(missing))
    if options.json:
        options.json.write_text(json.dumps([asdict(peer) for peer in found], indent=1))


if __name__ == "__main__":
    main()
