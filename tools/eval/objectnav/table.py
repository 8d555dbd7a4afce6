"""Tables I and II of [U]: SR and SPL of each planner, with intervals, and what went wrong."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.eval.objectnav.episode import Episode
from tools.eval.table import Figure

INFORMED, BLIND = ("I-FBE1", "I-FBE2"), ("closest", "random")
OTHER = "VLFM"


@dataclass(frozen=True, slots=True)
class Row:
    """One planner."""

    planner: str
    episodes: int
    success: Figure
    spl: Figure
    actions: Figure
    causes: dict[str, int]


def rows(episodes: list[Episode]) -> list[Row]:
    """A row for each planner, in the order of their first episode."""
    return [_row(name, mine) for name, mine in _by_planner(episodes).items()]


def _row(name: str, episodes: list[Episode]) -> Row:
    homes = [e.home for e in episodes]
    figures = (Figure.of([getattr(e, key) for e in episodes], homes) for key in ("success", "spl", "actions"))
    return Row(name, len(episodes), *figures, dict(Counter(e.cause for e in episodes if e.cause).most_common()))


def _by_planner(episodes: list[Episode]) -> dict[str, list[Episode]]:
    groups: dict[str, list[Episode]] = {}
    for episode in episodes:
        groups.setdefault(episode.planner, []).append(episode)
    return groups


def margin(episodes: list[Episode], one: str, other: str) -> tuple[Figure, Figure]:
    """What planner ``one`` has more of than the ``other`` on the same questions: (SR, SPL)."""
    groups = _by_planner(episodes)
    theirs = {(e.home, e.noun): e for e in groups[other]}
    pairs = [(e, theirs[e.home, e.noun]) for e in groups[one] if (e.home, e.noun) in theirs]
    homes = [mine.home for mine, _ in pairs]
    more = ([float(getattr(a, key)) - getattr(b, key) for a, b in pairs] for key in ("success", "spl"))
    return tuple(Figure.of(values, homes) for values in more)


def show(episodes: list[Episode]) -> str:
    """The table as text."""
    table = rows(episodes)
    lines = [f"{'planner':26} {'episodes':>8} {'SR':>19} {'SPL':>19} {'actions':>21}"]
    for row in table:
        lines.append(
            f"{row.planner:26} {row.episodes:8d} {row.success.show():>19} {row.spl.show():>19} "
            f"{row.actions.show('{:.0f}'):>21}"
        )
    for row in table:
        if row.causes:
            lines.append(f"{row.planner} failed: " + "; ".join(f"{n} {cause}" for cause, n in row.causes.items()))
    names = {row.planner for row in table}
    for one in INFORMED:
        for other in (*BLIND, OTHER):
            if {one, other} <= names:
                success, spl = margin(episodes, one, other)
                more = f"{success.show('{:+.3f}')} more SR and {spl.show('{:+.3f}')} more SPL"
                lines.append(f"{one} has {more} than {other}, on the same questions")
    lines.append("In brackets: 95 % intervals over resampled homes.")
    return "\n".join(lines)


def spread(episodes: list[Episode], kind: str) -> tuple[float, float, float]:
    """Least, greatest and standard deviation of SR over the planners whose name begins with ``kind``."""
    rates = [row.success.mean for row in rows(episodes) if row.planner.startswith(kind)]
    return min(rates), max(rates), float(np.std(rates))


def show_spread(episodes: list[Episode], kinds: tuple[str, ...]) -> str:
    """How much SR depends on the words, for the single-prompt planner and for ensembles: [U] Table I's point."""
    lines = []
    for kind in kinds:
        low, high, deviation = spread(episodes, kind)
        lines.append(f"SR of {kind}…: {low:.2f} to {high:.2f}, standard deviation {deviation:.3f}")
    return "\n".join(lines)


def draw(episodes: list[Episode], path: Path) -> None:
    """Bars of SR and SPL with 95 % intervals; the file's ending chooses the format."""
    from matplotlib.figure import Figure as Picture

    table = rows(episodes)
    picture = Picture(figsize=(7.0, 0.8 + 0.42 * len(table)), layout="constrained")
    axes = picture.subplots()
    for shift, key, label, colour in ((-0.19, "success", "SR", "#2a6f97"), (0.19, "spl", "SPL", "#e09f3e")):
        figures = [getattr(row, key) for row in table]
        reach = [[f.mean - f.low for f in figures], [f.high - f.mean for f in figures]]
        places = [number + shift for number in range(len(table))]
        look = {"color": colour, "ecolor": "#444444", "capsize": 3, "label": label}
        axes.barh(places, [f.mean for f in figures], 0.36, xerr=reach, **look)
    axes.set_yticks(range(len(table)), [row.planner for row in table])
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of episodes, and weighted by path length")
    axes.spines[["top", "right"]].set_visible(False)
    picture.legend(frameon=False, loc="outside upper center", ncols=2)
    picture.savefig(path, dpi=150)
