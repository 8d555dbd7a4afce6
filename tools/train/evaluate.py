"""Stage ``evaluate``: the finished pair on furniture it has never seen, the CC0 library that furnishes our homes."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from edge.perception.detection import DetectorConfig, salient_region
from edge.perception.encoder import Encoder
from edge.perception.prompts import Target
from tools.assets.catalog import Entry, open_library
from tools.eval.naming import Answer, Vocabulary, share
from tools.train.homes import shoot
from tools.train.words import noun

LIBRARY = "BlendSwap-CC-0"
HOMES = range(20, 28)  # seeds of generated homes
NOT_FURNITURE = {"Vehicles", "Characters", "Staircases"}
YAWS = np.radians([-30.0, 0.0, 40.0])  # from the front
PITCH = np.radians(18.0)
SIZE = (320, 240)  # px
WALL, GROUND = (205, 200, 190), (150, 130, 110)


@dataclass(frozen=True)
class Naming:
    """Shares of held-out pictures whose name is first, or among the first five, of all names."""

    top1: float
    top5: float
    seen_top1: float
    seen_top5: float
    unseen_top1: float
    unseen_top5: float
    names: int
    pictures: int


def held_out(libraries: dict[str, Path]) -> list[Entry]:
    """Models that stand in a home: no doors and windows, vehicles, characters or staircases."""
    return [e for e in open_library(libraries[LIBRARY]) if not e.door_or_window and e.category not in NOT_FURNITURE]


def render_held_out(libraries: dict[str, Path], folder: Path) -> None:
    """Write each held-out model from three yaws on a two-tone ground, filling the frame, as PNG; skip what is there."""
    from tools.assets.obj_model import load_mesh  # late: numba comes with the extra assets, homes need none
    from tools.assets.rasterizer import render
    from tools.train.sprites import FRONT

    library = open_library(libraries[LIBRARY])
    folder.mkdir(parents=True, exist_ok=True)
    for entry in held_out(libraries):
        files = [folder / f"{entry.id}.{i}.png" for i in range(len(YAWS))]
        if all(file.exists() for file in files):
            continue
        mesh = load_mesh(library, entry)
        for file, yaw in zip(files, YAWS):
            rgba = render(mesh, FRONT + yaw, PITCH, SIZE).rgba
            ground = np.empty((SIZE[1], SIZE[0], 3), np.float32)
            ground[: SIZE[1] * 3 // 5], ground[SIZE[1] * 3 // 5 :] = WALL, GROUND
            alpha = rgba[..., 3:].astype(np.float32) / 255
            rgb = np.clip(ground * (1 - alpha) + rgba[..., :3] * alpha, 0, 255).astype(np.uint8)
            cv2.imwrite(str(file), cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR))


def name_held_out(encoder: Encoder, entries: list[Entry], folder: Path) -> list[Answer]:
    """Name every picture of ``render_held_out`` among all held-out names; in the order of ``entries`` and yaws."""
    vocabulary = Vocabulary(encoder, sorted({noun(entry) for entry in entries}))
    answers = []
    for entry in entries:
        for i in range(len(YAWS)):
            picture = f"{entry.id}.{i}.png"
            rgb = cv2.cvtColor(cv2.imread(str(folder / picture)), cv2.COLOR_BGR2RGB)
            answers.append(vocabulary.ask(picture, rgb, (noun(entry),)))
    return answers


def score(answers: list[Answer], trained: set[str]) -> Naming:
    """``trained`` are the names that training used: their pictures are "seen" (the noun, never the model)."""
    seen = [answer for answer in answers if answer.truth in trained]
    unseen = [answer for answer in answers if answer.truth not in trained]
    values = [share(chosen, k) for chosen in (answers, seen, unseen) for k in (1, 5)]
    return Naming(*values, len({answer.truth for answer in answers}), len(answers))


def parity(quantized: Encoder, exact: Encoder, folder: Path) -> float:
    """Median cosine between the whole-picture vectors of two encoders over the held-out pictures."""
    cosines = []
    for file in sorted(folder.glob("*.png")):
        rgb = cv2.cvtColor(cv2.imread(str(file)), cv2.COLOR_BGR2RGB)
        cosines.append(quantized.encode_image(rgb).vectors[0] @ exact.encode_image(rgb).vectors[0])
    return round(float(np.median(cosines)), 4)


def evaluate_homes(encoder: Encoder, seeds: range = HOMES) -> dict:
    """Over generated homes: how views rank for the objects they show, and where Grad-CAM points in them.

    ``first``/``within10``: queries for which a view that truly shows the object is first / among ten of 120;
    ``pointing``: share of shown objects with the saliency's peak inside their mask (15 px tolerance, as Zhang et al.
    2016); ``iou``: mean overlap of the box with the mask's box, for objects with a box.
    """
    ranks, pointing, overlaps = [], [], []
    for seed in seeds:
        names, shots = shoot(seed)
        views = [encoder.encode_image(shot.rgb) for shot in shots]
        for name in sorted(set(names)):
            direction = Target.of(name.lower(), encoder).direction
            mine = [i for i, other in enumerate(names) if other == name]
            shown = np.array([shot.shown[mine].any() for shot in shots])
            if not shown.any():
                continue
            scores = np.array([(view.vectors @ direction).max() for view in views])
            ranks.append(int((scores > scores[shown].max()).sum()))
            for i in np.flatnonzero(shown):
                mask = np.isin(shots[i].instances, mine).astype(np.uint8)
                hit, overlap = _localize(encoder.saliency(views[i], direction), mask)
                pointing.append(hit)
                overlaps.append(overlap)
    ranks = np.array(ranks)
    share = lambda hits: round(float(np.mean(hits)), 4)  # noqa: E731
    return {
        "queries": len(ranks), "first": share(ranks < 1), "within10": share(ranks < 10),
        "sightings": len(pointing), "pointing": share(pointing), "iou": share(overlaps),
    }  # fmt: skip


def _localize(saliency: np.ndarray, mask: np.ndarray) -> tuple[bool, float]:
    """Whether the peak of the enlarged map lies in ``mask`` (H, W), and the box's intersection over union with it."""
    size = mask.shape[1], mask.shape[0]
    region = salient_region(saliency, size, DetectorConfig.level)
    if region is None:
        return False, 0.0
    box, _ = region
    enlarged = cv2.resize(saliency, size, interpolation=cv2.INTER_LINEAR)
    v, u = np.unravel_index(int(enlarged.argmax()), enlarged.shape)
    near = mask[max(0, v - 15) : v + 16, max(0, u - 15) : u + 16].any()
    ys, xs = np.nonzero(mask)
    return bool(near), _overlap(box, (xs.min(), ys.min(), xs.max() + 1, ys.max() + 1))


def _overlap(a, b) -> float:
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    shared = max(0.0, width) * max(0.0, height)
    area = lambda box: (box[2] - box[0]) * (box[3] - box[1])  # noqa: E731
    return shared / (area(a) + area(b) - shared)
