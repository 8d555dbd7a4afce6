"""Tables I and II of [U]: SR and SPL of each planner, with intervals, and what went wrong."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.eval.bootstrap import middle, resampled
from tools.eval.objectnav.episode import Episode
from tools.eval.table import Figure

INFORMED = "I-FBE1", "I-FBE2"
BASELINES = "closest", "random", "VLFM"  # the last also with each of its prompts
SINGLE, ENSEMBLES = "VLFM, prompt", "I-FBE2, prompts"  # how the names begin in Table I


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
    names = [row.planner for row in table]
    for one in filter(names.__contains__, INFORMED):
        for other in (name for name in names if name.startswith(BASELINES)):
            success, spl = margin(episodes, one, other)
            more = f"{success.show('{:+.3f}')} more SR and {spl.show('{:+.3f}')} more SPL"
            lines.append(f"{one} has {more} than {other}, on the same questions")
    lines.append("In brackets: 95 % intervals over resampled homes.")
    return "\n".join(lines)


def spread(episodes: list[Episode]) -> tuple[dict[str, np.ndarray], Figure]:
    """How much SR depends on the words, for single prompts and for ensembles: [U] Table I's point.

    Returns the SR of each of ``SINGLE`` and ``ENSEMBLES``, and by how much its standard deviation over the single
    prompts is larger, over resampled homes.
    """
    homes = sorted({episode.home for episode in episodes})
    counts = {kind: _counts(episodes, kind, homes) for kind in (SINGLE, ENSEMBLES)}

    def rates(kind, times):
        right, asked = counts[kind] @ times
        return right / asked

    def more(times):
        return float(rates(SINGLE, times).std() - rates(ENSEMBLES, times).std())

    once, drawn = np.ones(len(homes)), resampled(len(homes))
    return {kind: rates(kind, once) for kind in counts}, Figure(more(once), *middle([more(times) for times in drawn]))


def _counts(episodes: list[Episode], kind: str, homes) -> np.ndarray:
    """``(2, planners, homes)``: how often the planners whose name begins with ``kind`` were right, and were asked."""
    groups = [mine for name, mine in _by_planner(episodes).items() if name.startswith(kind)]
    place, counts = {home: column for column, home in enumerate(homes)}, np.zeros((2, len(groups), len(homes)))
    for row, mine in enumerate(groups):
        for episode in mine:
            counts[:, row, place[episode.home]] += episode.success, 1
    return counts


def show_spread(episodes: list[Episode]) -> str:
    """``spread`` as text."""
    rates, more = spread(episodes)
    lines = [
        f"SR of {kind}…: {found.min():.2f} to {found.max():.2f}, standard deviation {found.std():.3f}"
        for kind, found in rates.items()
    ]
    return "\n".join([*lines, f"by {more.show('{:+.3f}')} larger with a single prompt"])


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
