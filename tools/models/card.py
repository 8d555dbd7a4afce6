"""``MODEL_CARD.md`` of an imported pair: where it is from, and what was measured on the way."""

from models.manifest import Manifest
from tools.models.pair import Pair
from tools.models.quantization import LEAST, Version

CARD = """\
# {name}

Imported with `vlpg models import`. sha256 of all files together: `{digest}`.

- Source: {source}
- Licence of the weights: {licence}
- Image tower: {kind}, {height} x {width} px; vectors of {dim} dimensions. Pictures are **stretched** to that size, not
  cropped in the middle as its training may have done: a crop would blind the robot's sides.
- One vector a picture; parts of it are looked at by passes of their own.
- Text tower: up to {context} tokens{filling}. Saliency: Grad-CAM, the tower's backward pass behind its last
  spatial map as a graph.

## Stored as

| graph | numbers | MB | ms | median cosine |
|---|---|---|---|---|
{rows}

Milliseconds of one thread's time on the importing machine. Cosine of the towers' vectors to the source framework's,
over {pictures} views of simulated homes and {prompts} prompts. A version whose cosine is below {least}, or that is much
slower than float32, is not taken. The float32 graphs differ from the source framework by at most {export:.1e} in any
component.

## Measured

In {homes} generated homes, 120 views each, {queries} queries by name: a view that truly shows the thing is first for
{first:.0%} and among the first ten for {within10:.0%}. Grad-CAM's peak lies on the thing in {pointing:.0%} of
{sightings} sightings; mean overlap of its box {iou:.2f}. `vlpg eval encoder --model {name}` measures it in more homes.

A process with one tower takes at most {image_memory:g} MB (image) and {text_memory:g} MB (text).

Relevance, sigmoid({slope:g} * cosine {offset:+g}), was fitted on views of other generated homes in which the truth is
known. The homes are simulated; nothing here was measured on photographs.
"""


def write(manifest: Manifest, pair: Pair, versions: dict[str, Version], counts: dict[str, int]) -> str:
    """The card's text. ``versions``: the graphs that were chosen, by title; ``counts``: pictures, prompts."""
    sizes = {file.name: file.size for file in manifest.files}
    rows = []
    for title, version in versions.items():
        graph = f"{title}.onnx"
        size = (sizes[graph] + sizes.get(f"{graph}.data", 0)) / 1e6
        rows.append(f"| {title} | {version.name} | {size:.1f} | {version.milliseconds:.1f} | {version.cosine:.4f} |")
    measured = manifest.measured
    return CARD.format(
        name=manifest.name, digest=manifest.digest, source=manifest.source, kind=pair.kind,
        licence=manifest.licence or "unknown: ask the source", height=pair.height, width=pair.width, dim=manifest.dim,
        context=pair.context_length, filling="" if pair.pad_id is None else ", filled up to that length",
        rows="\n".join(rows), least=LEAST, export=measured["export_error"], slope=manifest.relevance.slope,
        offset=manifest.relevance.offset, **counts,
        **{key: measured[key] for key in ("homes", "queries", "first", "within10", "pointing", "sightings", "iou")},
        image_memory=measured["image_memory"], text_memory=measured["text_memory"],
    )  # fmt: skip
