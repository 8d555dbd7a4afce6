"""Stage ``card``: ``MODEL_CARD.md`` from what the other stages measured."""

from models.manifest import Manifest
from tools.train.fetch import PACKAGES
from tools.train.sprites import LIBRARIES

CARD = """\
# {name}

A vision-language pair for small robots: an int8 EfficientNet-Lite0 image tower ({height} x {width} px) and the int8
all-MiniLM-L6-v2 sentence encoder, in one space of {dim} dimensions. Runs with ONNX Runtime alone. sha256 of all files
together: `{digest}`.

## What it is made of

- *Text*: all-MiniLM-L6-v2, locked; mean pooling and normalization in the graph; int8 word table and matrices.
- *Image*: ImageNet's EfficientNet-Lite0. Its first eleven blocks are as they came; the last five are fine-tuned. A neck
  joins the last block's map to the middle one (as in a feature pyramid, Lin et al. 2017), so that there is a map of
  {cells}. On the pooled features of both maps two branches are summed: a linear projection trained against the text
  tower (LiT, Zhai et al. 2022), and ImageNet's class posterior averaged over the text embeddings of the classes'
  WordNet names (ConSE, Norouzi et al. 2014), with weight {share}.
- One pass gives the vectors of the whole picture and of its left, middle and right third, and the two maps.
- `saliency.onnx` evaluates Grad-CAM in closed form on them; a test holds it to PyTorch's autograd within 1e-4.

## Training

{scenes} composite pictures of rendered furniture ({libraries}; CC-BY 3.0; used for training only, nothing of them is
shipped) in made-up rooms: 1-6 objects, close-ups, enlarged parts and empty rooms, with blur, noise and changing light.
Names come from the catalogs' names and tags through {templates} templates. Three losses: naming (sigmoid and softmax
over all names, near-synonyms not counted as wrong), pointing (the closed-form Grad-CAM should peak on the object's mask
and cover it), and the divergence of the class posterior from that of the network before fine-tuning.

The CC0 library (BlendSwap-CC-0) that furnishes the simulated homes, and the homes themselves, were never trained on.
The choice of method was made on {held} models held out of training (figures of the homes and of the CC0 pictures were
printed beside them, and not chosen by); the shipped weights are then trained on all models of those libraries.

## Measured

Held-out CC0 models without doors and windows, vehicles, characters and staircases: {names} names, {pictures} pictures
(3 yaws each, filling the frame on a plain two-tone ground), ranked among all {names} names. "Seen" means that training
knew the noun, never the model. `python -m tools.train evaluate` prints these figures.

| | top-1 | top-5 | seen top-1 | seen top-5 | unseen top-1 | unseen top-5 |
|---|---|---|---|---|---|---|
{rows}

Median cosine of int8 to float32 vectors on those pictures: {parity}.

In 8 generated homes (seeds 20-27), 120 random views each, {queries} queries by name: a view that truly shows the object
(more than 0.4 % of the picture and 40 % of its silhouette) is ranked first for {first:.0%} and among the first ten for
{within10:.0%}. Grad-CAM's peak lies on the object (15 px tolerance) in {pointing:.0%} of {sightings} sightings; mean
intersection over union of its box {iou:.2f}.

Validation models (non-CC0, held out while choosing the method): close-ups top-1 {v1:.0%}, top-5 {v5:.0%}; of 120 views
a right one is first for {vf:.0%}, among ten for {vt:.0%} of the queries; Grad-CAM's strongest cell lies on the thing in
{vp:.0%} of the sightings.

## Limits

It knows furniture and household things as rendered models; real photographs were not part of the training and are not
measured here. Small objects (below about 20 px) and plain boxes (cabinets, fridges, lockers) are often confused.
Nouns that neither the catalogs nor ImageNet know rely on the text tower's sense of similarity alone. Grad-CAM's map has
{cells}: boxes of small things are coarse.

## Sources and licences

{sources}
- Furniture used for training: KatorLegaz (Andrew Kator and Jennifer Legaz), Scopia, and the contributors of Blend Swap,
  as collected by Sweet Home 3D; Creative Commons Attribution 3.0.

The weights and this card: Apache-2.0.
"""


def write(
    manifest: Manifest, scenes: int, held: int, templates: int, share: float, validation: dict, results: dict
) -> str:
    """The card's text from the validation and evaluation reports of the pipeline."""
    keys = ("top1", "top5", "seen_top1", "seen_top5", "unseen_top1", "unseen_top5")
    rows = [
        f"| {kind} | " + " | ".join(f"{100 * results[kind][key]:.1f} %" for key in keys) + " |"
        for kind in ("int8", "float32")
    ]
    scores, homes = validation["scores"], results["homes"]
    return CARD.format(
        name=manifest.name, dim=manifest.dim, digest=manifest.digest, height=manifest.image.height,
        width=manifest.image.width, share=share,
        cells=f"{manifest.image.height // 16} x {manifest.image.width // 16} cells",
        scenes=f"{scenes:,}", libraries=", ".join(LIBRARIES), templates=templates, held=held,
        names=results["int8"]["names"], pictures=results["int8"]["pictures"], rows="\n".join(rows),
        parity=results["parity"], **{key: homes[key] for key in ("queries", "first", "within10", "sightings")},
        pointing=homes["pointing"], iou=homes["iou"], v1=scores["top1"], v5=scores["top5"], vf=scores["first"],
        vt=scores["within10"], vp=scores["pointing"],
        sources="\n".join(f"- `{p.requirement}` ({p.licence}), sha256 `{p.sha256}`" for p in PACKAGES),
    )  # fmt: skip
