"""``vlpg models import``: another framework's pair as one of the user's own models."""

import shutil
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import onnx

from edge.perception.encoder import Encoder
from edge.perception.preprocess import preprocess
from models.manifest import Image, Manifest, resolve
from tools.models import card, homes, quantization
from tools.models.loading import loading
from tools.models.measure import measure
from tools.models.pair import IMAGE, SALIENCY, TEXT, TOKENIZER, Pair
from tools.models.parity import PROMPTS, Truth
from tools.models.quantization import Version
from tools.models.shelf import new_model
from tools.train.evaluate import HOMES, evaluate_homes
from tools.train.package import write_manifest

RANGES = 64  # pictures that set the int8 ranges
PARITY = 24  # pictures that are compared with the source framework
MEASURED = HOMES[:2]  # homes of the measurement; `vlpg eval encoder` measures all of them

Report = Callable[[str], None]


def import_pair(pair: Pair, name: str, report: Report = lambda line: None) -> Manifest:
    """Export ``pair``, quantize what keeps its word, calibrate, measure, and put it on the user's shelf as ``name``.

    Raises:
        ModelError: the name is taken, or the graphs do not say what the source framework says.
    """
    with new_model(name) as folder, TemporaryDirectory() as scratch:
        work = Path(scratch)
        report("exporting both towers and Grad-CAM")
        with loading(pair.source, "exported"):
            pair.export(work)
        # Whole pictures only: what is small is looked at by a pass of its own.
        image = Image(IMAGE, SALIENCY, pair.height, pair.width, pair.mean, pair.std, ((0.0, 1.0),))
        truth = Truth(pair, [preprocess(rgb, image) for rgb in homes.pictures(homes.PARITY, PARITY)], work)
        error = truth.check_export()
        report(f"the graphs say what the source says, to {error:.0e}; quantizing")
        versions = _quantize(truth, image, work)
        for title, version in versions.items():
            _take(version.path, folder / f"{title}.onnx")
            report(f"{title}: {version.name}, cosine {version.cosine:.4f}, {version.milliseconds:.1f} ms")
        shutil.copy(work / TOKENIZER, folder)
        fields = _fields(pair, name, image, work) | {"measured": _measured(versions, error)}
        write_manifest(folder, fields)
        report("calibrating and measuring in simulated homes")
        fields["relevance"] = homes.fit_relevance(Encoder.load(folder), homes.RELEVANCE, homes.VIEWS)
        write_manifest(folder, fields)
        fields["measured"] |= {"homes": len(MEASURED)} | evaluate_homes(Encoder.load(folder), MEASURED)
        fields["measured"] |= measure(Manifest.load(folder))
        write_manifest(folder, fields)
        counts = {"pictures": PARITY, "prompts": len(PROMPTS)}
        (folder / "MODEL_CARD.md").write_text(card.write(Manifest.load(folder), pair, versions, counts))
    return Manifest.load(resolve(name))


def _quantize(truth: Truth, image: Image, work: Path) -> dict[str, Version]:
    """The version of each graph that is taken, by title."""

    def pictures():
        return (preprocess(rgb, image) for rgb in homes.pictures(homes.RANGES, RANGES))

    images = quantization.image_versions(work / IMAGE, work, pictures)
    texts = quantization.text_versions(work / TEXT, work)
    saliency = work / SALIENCY
    return {
        "image": quantization.choose(images, truth.image_cosine, truth.image_milliseconds),
        "text": quantization.choose(texts, truth.text_cosine, truth.text_milliseconds),
        # Stored in int8 it takes twice the time and no less memory, where it computes in float32 all the same.
        "saliency": Version(quantization.FLOAT32, saliency, 1.0, truth.saliency_milliseconds(saliency)),
    }


def _take(source: Path, target: Path) -> None:
    """A copy of a graph under its final name, its weights beside it."""
    from tools.models.export import save

    save(onnx.load(source), target)


def _fields(pair: Pair, name: str, image: Image, work: Path) -> dict:
    """The manifest without its files, and with a relevance that stands in until it is fitted."""
    dim = onnx.load(work / IMAGE, load_external_data=False).graph.output[0].type.tensor_type.shape.dim[1].dim_value
    text = {"graph": TEXT, "tokenizer": TOKENIZER, "context_length": pair.context_length}
    return {
        "name": name,
        "source": pair.source,
        "licence": pair.licence,
        "dim": dim,
        "logit_scale": pair.logit_scale,
        "image": {**vars(image)},
        "text": text if pair.pad_id is None else text | {"pad_id": pair.pad_id},
        "relevance": {"slope": 1.0, "offset": 0.0},
    }


def _measured(versions: dict[str, Version], error: float) -> dict[str, float]:
    figures = {"export_error": float(f"{error:.1e}")}
    for title, version in versions.items():
        figures[f"{title}_cosine"] = round(version.cosine, 4)
        figures[f"{title}_ms"] = float(f"{version.milliseconds:.3g}")
    return figures
