"""How far the confidence of answers can be believed: a reliability table and picture, and the fit behind it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from models.manifest import Confidence, logit
from tools.eval.bootstrap import interval
from tools.eval.episode import Episode
from tools.eval.table import name_of
from tools.logistic import logistic

BINS = 5
RIDGE = 1.0  # of the fit: as if it were known that weights are hardly larger than 1


@dataclass(frozen=True, slots=True)
class Bin:
    """Claims whose confidence is alike."""

    claims: int
    stated: float  # mean confidence
    right: float  # share of the claims that were
    low: float  # 95 % interval of it, over resampled homes
    high: float


def claims_of(episodes: list[Episode]) -> list[Episode]:
    """What the whole method claims where nothing was disturbed or told it; other methods state no confidence."""
    return [e for e in episodes if e.status == "found" and name_of(e) == "vlpg-nav"]


def seen(claims: list[Episode]) -> list[Episode]:
    """Claims that rest on a sighting. The others are guesses: nothing was recognized from any viewpoint."""
    return [e for e in claims if not np.isnan(e.score)]


def bins(claims: list[Episode], count: int = BINS) -> list[Bin]:
    """``count`` bins of (nearly) equal size, from the least to the most confident."""
    ordered = sorted(claims, key=lambda e: e.confidence)
    found = []
    for part in np.array_split(np.arange(len(ordered)), min(count, len(ordered))) if ordered else ():
        mine = [ordered[i] for i in part]
        right = [e.success for e in mine]
        stated = float(np.mean([e.confidence for e in mine]))
        found.append(Bin(len(mine), stated, float(np.mean(right)), *interval(right, [e.home for e in mine])))
    return found


def calibration_error(found: list[Bin]) -> float:
    """Mean distance between what is stated and what is right, weighted by claims (Naeini et al. 2015); NaN if none."""
    total = sum(b.claims for b in found)
    return sum(b.claims * abs(b.stated - b.right) for b in found) / total if total else float("nan")


def brier(claims: list[Episode]) -> float:
    """Mean squared error of the confidences (Brier 1950); NaN without a claim."""
    return float(np.mean([(e.confidence - e.success) ** 2 for e in claims])) if claims else float("nan")


def show(claims: list[Episode]) -> str:
    """The table as text."""
    found = bins(claims)
    lines = ["claims  stated  right"]
    lines += [f"{b.claims:6d}  {b.stated:6.2f}  {b.right:.2f} [{b.low:.2f}, {b.high:.2f}]" for b in found]
    errors = f"calibration error {calibration_error(found):.3f}, Brier score {brier(claims):.3f}"
    guesses = len(claims) - len(seen(claims))
    return "\n".join([*lines, f"{errors}, {len(claims)} claims, {guesses} of them guesses"])


def fit(claims: list[Episode]) -> Confidence:
    """The weights of ``Confidence`` that make the truth of ``claims``, all ``seen``, most probable.

    Raises ValueError when all claims are right, or all are wrong: nothing tells them apart then.
    """
    evidence = np.array([(logit(e.score), logit(e.remembered)) for e in claims]).reshape(-1, 2)
    weights = logistic(evidence, [e.success for e in claims], ridge=RIDGE)
    return Confidence(*(round(float(value), 3) for value in weights))


def draw(claims: list[Episode], path: Path) -> None:
    """The reliability diagram: stated against right, with intervals; the file's ending chooses the format."""
    from matplotlib.figure import Figure

    found = bins(claims)
    figure = Figure(figsize=(4.2, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color="#999999", linewidth=1, linestyle="--", label="calibrated")
    middle = [b.right for b in found]
    reach = [[b.right - b.low for b in found], [b.high - b.right for b in found]]
    stated = [b.stated for b in found]
    axes.errorbar(stated, middle, yerr=reach, color="#2a6f97", marker="o", capsize=3, label="claims, in equal bins")
    axes.set(xlim=(0, 1), ylim=(0, 1), xlabel="confidence stated", ylabel="share of claims that were right")
    axes.set_aspect("equal")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="upper left")
    figure.savefig(path, dpi=150)
