"""Stage ``card``: ``MODEL_CARD.md`` from what the other stages measured."""

import textwrap
from pathlib import Path

from models.manifest import Manifest
from tools.eval.photographs import PHOTOGRAPHS
from tools.eval.sheets import CONFUSIONS, HELD_OUT, PHOTOS
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

{scenes} composite pictures of rendered furniture ({libraries}; CC-BY 3.0
and Free Art 1.3; used for training only, nothing of them is shipped) in made-up rooms: 1-6 objects, close-ups, enlarged
parts and empty rooms, with blur, noise, changing light, and two things in five in another colour.
Names come from the catalogs' names and tags through {templates} templates. Three losses: naming (sigmoid and softmax
over all names, near-synonyms not counted as wrong), pointing (the closed-form Grad-CAM should peak on the object's mask
and cover it), and the divergence of the class posterior from that of the network before fine-tuning.

The CC0 library (BlendSwap-CC-0) that furnishes the simulated homes, and the homes themselves, were never trained on.
The choice of method was made on {held} models held out of training (figures of the homes and of the CC0 pictures were
printed beside them, and not chosen by); the shipped weights are then trained on all models of those libraries. The
committed weights were made in two rounds, the first one with three of the libraries only; the stages do both at once.

## Measured

`python -m tools.train evaluate` measures all of this and `python -m tools.train card` writes it here. In parts:
`vlpg eval encoder` (names, homes, photographs), `vlpg bench peers encoder` (speed, memory), `vlpg models verify {name}`
(int8 against float32, speed and memory, compared with the figures of `manifest.json`, measured apart from those below).

### Names

Held-out CC0 models without doors and windows, vehicles, characters and staircases: {names} names, {pictures} pictures
(3 yaws each, filling the frame on a plain two-tone ground), ranked among all {names} names. "Seen" means that training
knew the noun, never the model.

| | top-1 | top-5 | seen top-1 | seen top-5 | unseen top-1 | unseen top-5 |
|---|---|---|---|---|---|---|
{rows}

Int8 loses {lost:.1f} points of top-5 to float32; median cosine of its vectors to float32's on those pictures: {parity}.

![Every held-out model with the three names found likeliest]({held_out_sheet})

*Every held-out model from the front, with its three likeliest names. Green: the right one is first; orange: second or
third.*

### Homes

In 8 generated homes (seeds 20-27), 120 random views each, {queries} queries by name: a view that truly shows the object
(more than 0.4 % of the picture and 40 % of its silhouette) is ranked first for {first:.0%} and among the first ten for
{within10:.0%}. Grad-CAM's peak lies on the object (15 px tolerance) in {pointing:.0%} of {sightings} sightings; mean
intersection over union of its box {iou:.2f}.

Validation models (non-CC0, held out while choosing the method): close-ups top-1 {v1:.0%}, top-5 {v5:.0%}; of 120 views
a right one is first for {vf:.0%}, among ten for {vt:.0%} of the queries; Grad-CAM's strongest cell lies on the thing in
{vp:.0%} of the sightings.

### Speed and memory

{machine}, one thread, a shared machine: the towers run in turns, a process each,
and the ratio is the median over the turns. Peak PSS is that of a process with numpy, the runtime and the image tower,
by itself. "As on the robot" has the robot's settings of ONNX Runtime and of malloc, the peers have their own. With
OpenCV and preprocessing, too, our image side takes {encoder_memory:.0f} MB. A text pass takes {text_p50:.1f} ms (p50).

| image tower | p50 | p10 - p90 | times ours | peak PSS | anonymous + file-backed |
|---|---|---|---|---|---|
{peers}

### Real photographs

None was trained on, apart from ImageNet in the trunk's past. These {photo_count} come with scikit-image and
scikit-learn; the right names compete with those of all furniture and with everyday nouns, {photo_names} names in all.
Right at first guess: {photo_top1:.0%}; among the first five: {photo_top5:.0%}. Few as they are, they are an impression,
not a score.

| photograph | what it shows | its place among all names | named |
|---|---|---|---|
{photographs}

![The photographs with the three names found likeliest]({photographs_sheet})

{credits}

## Failures

Most often mistaken, of the {pictures} held-out pictures:

| it is | it is called | pictures |
|---|---|---|
{confusions}

![Examples of the most frequent confusions]({confusions_sheet})

{said_too_often}

{never}

## Limits

It knows furniture and household things as rendered models; real photographs were not part of the training. Small
objects (below about 20 px) and plain boxes (cabinets, fridges, lockers) are often confused. Nouns that neither the
catalogs nor ImageNet know rely on the text tower's sense of similarity alone. Grad-CAM's map has {cells}: boxes of
small things are coarse.

## Sources and licences

{sources}
- Furniture used for training: KatorLegaz (Andrew Kator and Jennifer Legaz), Scopia, and the contributors of Blend Swap,
  as collected by Sweet Home 3D; Creative Commons Attribution 3.0. LucaPresidente and the contributors of Sweet Home 3D
  (Contributions); Free Art License 1.3.
- Furniture in the pictures of this card and in `reference.npz`: contributors of Blend Swap, CC0, credited one by one in
  `firmware_sim/furniture_pack/CREDITS.md`.

The weights and this card: Apache-2.0; the photographs on its sheet as credited there.
"""


def write(
    manifest: Manifest, scenes: int, held: int, templates: int, share: float, validation: dict, results: dict
) -> str:
    """The card's text from the validation and evaluation reports of the pipeline."""
    keys = ("top1", "top5", "seen_top1", "seen_top5", "unseen_top1", "unseen_top5")
    scores = {kind: [f"{100 * results[kind][key]:.1f} %" for key in keys] for kind in ("int8", "float32")}
    naming, homes, photos = results["int8"], results["homes"], results["photographs"]
    checked = validation["scores"]
    return CARD.format(
        name=manifest.name, dim=manifest.dim, digest=manifest.digest, height=manifest.image.height,
        width=manifest.image.width, share=share,
        cells=f"{manifest.image.height // 16} x {manifest.image.width // 16} cells",
        scenes=f"{scenes:,}", libraries=", ".join(LIBRARIES), templates=templates, held=held,
        names=naming["names"], pictures=naming["pictures"], rows=_table((kind, *row) for kind, row in scores.items()),
        lost=100 * (results["float32"]["top5"] - naming["top5"]), parity=results["parity"],
        **{key: homes[key] for key in ("queries", "first", "within10", "sightings", "pointing", "iou")},
        v1=checked["top1"], v5=checked["top5"], vf=checked["first"], vt=checked["within10"], vp=checked["pointing"],
        machine=results["machine"], text_p50=manifest.measured["text_p50"],
        encoder_memory=manifest.measured["encoder_memory"], peers=_peers(results["peers"]),
        photo_count=photos["pictures"], photo_names=photos["names"], photo_top1=photos["top1"],
        photo_top5=photos["top5"], photographs=_photographs(photos["answers"]), credits=_credits(),
        confusions=_table(naming["confusions"]),
        never=_list("Never among the first five, from no yaw", naming["never_in_top5"]),
        said_too_often=_list(
            "Most often said of something else", [f"{name} ({times})" for name, times in naming["said_too_often"]]
        ),
        held_out_sheet=HELD_OUT, confusions_sheet=CONFUSIONS, photographs_sheet=PHOTOS,
        sources="\n".join(f"- `{p.requirement}` ({p.licence}), sha256 `{p.sha256}`" for p in PACKAGES),
    )  # fmt: skip


def _table(rows) -> str:
    """Rows of a Markdown table."""
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows)


def _peers(peers: list[dict]) -> str:
    return _table(
        (
            peer["name"], f"{peer['p50']:.1f} ms", f"{peer['p10']:.1f} - {peer['p90']:.1f} ms", f"{peer['ratio']:.2f}",
            f"{peer['peak']:.1f} MB", f"{peer['anonymous']:.0f} + {peer['file_backed']:.0f} MB",
        )
        for peer in peers
    )  # fmt: skip


def _photographs(answers: list[dict]) -> str:
    return _table(
        (Path(answer["picture"]).name, answer["truth"], answer["rank"] + 1, ", ".join(answer["best"][:3]))
        for answer in answers
    )


def _credits() -> str:
    return _list("Credits", [f"{Path(p.file).name} {p.credit}" for p in PHOTOGRAPHS if p.credit], "; ")


def _list(title: str, items: list[str], between: str = ", ") -> str:
    """One sentence, in lines of at most 120 characters."""
    return textwrap.fill(f"{title}: {between.join(items) or 'none'}.", 120, break_on_hyphens=False)
