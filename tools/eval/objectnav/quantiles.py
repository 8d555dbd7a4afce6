"""Fig. 3 of [U]: are the similarities of one picture to many wordings of one question normally distributed?"""

from itertools import product
from pathlib import Path
from statistics import NormalDist

import numpy as np

from edge.perception.encoder import Encoder
from edge.perception.prompts import ENSEMBLE
from firmware_sim.free_space import FreeSpace
from firmware_sim.home import load_home
from firmware_sim.placement import ROBOT_RADIUS
from firmware_sim.world import World
from tools.eval.objectnav.campaign import chosen

COUNTS = (10, 20, 50, 100)  # prompts; [U] shows 10 to 100
PICTURES = 8  # a home and object
_HEDGES = ("", "Seems like ", "Looks like ", "Perhaps ", "Probably ")
_CLAIMS = (
    "there is a {}",
    "a {} is",
    "one can find a {}",
    "a {} can be",
    "someone keeps a {}",
)
_PLACES = (" ahead", " in the vicinity", " around here", " nearby")


def wordings() -> list[str]:
    """A hundred prompts: the seven of [U] Table I first."""
    composed = ("".join(parts) for parts in product(_HEDGES, _CLAIMS, _PLACES))
    rest = [text for text in (text[0].upper() + text[1:] for text in composed) if text not in ENSEMBLE]
    rng = np.random.default_rng(0)
    return [*ENSEMBLE, *(rest[i] for i in rng.permutation(len(rest))[: max(COUNTS) - len(ENSEMBLE)])]


def similarities(homes: list[str], encoder: str, objects: int | None, seed: int) -> dict[int, np.ndarray]:
    """Standardized cosines ``(pictures, prompts)``, sorted, of pictures from random places, by the number of prompts.

    Raises HouseError or ModelError.
    """
    tower, rows = Encoder.load(encoder), []
    for home in homes:
        house, rng = load_home(home), np.random.default_rng(seed)
        free = FreeSpace(house)
        cells = np.argwhere(free.reachable(ROBOT_RADIUS))
        for noun in chosen(house, objects):
            words = tower.encode_text([wording.format(noun) for wording in wordings()])
            for row, col in cells[rng.integers(len(cells), size=PICTURES)]:
                start = np.array([*free.frame.to_world(row, col), rng.uniform(-np.pi, np.pi)])
                picture = World(house, seed, start=start).step(None).frame.rgb
                rows.append(words @ tower.encode_image(picture).vectors[0])
    cosines = np.array(rows)
    found = {}
    for count in COUNTS:
        mine = cosines[:, :count]
        found[count] = np.sort((mine - mine.mean(1, keepdims=True)) / mine.std(1, keepdims=True), axis=1)
    return found


def normal_quantiles(count: int) -> np.ndarray:
    """Expected standard normal quantiles ``(count,)`` of a sorted sample (Hazen's positions)."""
    return np.array([NormalDist().inv_cdf((i + 0.5) / count) for i in range(count)])


def straightness(values: np.ndarray) -> float:
    """Mean over pictures of the correlation between sorted ``values (pictures, prompts)`` and normal quantiles.

    1 is exactly normal (Filliben 1975).
    """
    expected = normal_quantiles(values.shape[1])
    return float(np.mean([np.corrcoef(row, expected)[0, 1] for row in values]))


def normal_straightness(count: int) -> float:
    """``straightness`` of samples that are normal: less than 1 when they are small."""
    return straightness(np.sort(np.random.default_rng(0).standard_normal((2000, count))))


def draw(spreads: dict[int, np.ndarray], path: Path) -> None:
    """A panel for each number of prompts; median and the middle 90 % of pictures."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.6 * len(spreads), 2.9), layout="constrained")
    panels = figure.subplots(1, len(spreads), sharey=True)
    for axes, (count, values) in zip(panels, spreads.items()):
        expected = normal_quantiles(count)
        low, middle, high = np.quantile(values, (0.05, 0.5, 0.95), axis=0)
        axes.plot([-3, 3], [-3, 3], color="#999999", linewidth=1)
        axes.fill_between(expected, low, high, color="#2a6f97", alpha=0.25, linewidth=0)
        axes.plot(expected, middle, ".", color="#2a6f97", markersize=4)
        axes.set_title(f"{count} prompts, r = {straightness(values):.3f}", fontsize=9)
        axes.set_xlabel("normal quantile")
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel("similarity, standardized")
    figure.savefig(path, dpi=150)
