"""Success, SAE and errors of the methods as a picture: Tables II and III of [V]."""

from pathlib import Path

from tools.eval.episode import Episode
from tools.eval.table import rows


def draw(episodes: list[Episode], path: Path) -> None:
    """Bars with 95 % intervals, two pairs a method, one above the other; the file's ending chooses the format."""
    from matplotlib.figure import Figure

    table = rows(episodes)
    figure = Figure(figsize=(1.2 + 1.6 * len(table), 6.0), layout="constrained")
    shares, angles = figure.subplots(2, sharex=True)
    pixels = angles.twinx()
    _bars(shares, table, "success", -1, "success", "#2a6f97")
    _bars(shares, table, "sae", 1, "SAE", "#e09f3e")
    _bars(angles, table, "degrees", -1, "degrees", "#5b8e55")
    _bars(pixels, table, "pixels", 1, "pixels", "#b56576")
    shares.set_ylim(0, 1)
    shares.set_ylabel("share of episodes")
    angles.set_ylabel("degrees off, of the successful")
    pixels.set_ylabel("pixels off")
    angles.set_xticks(range(len(table)), [row.method for row in table])
    shares.spines[["top", "right"]].set_visible(False)
    for axes in (angles, pixels):
        axes.set_ylim(bottom=0)
        axes.spines["top"].set_visible(False)
    figure.legend(frameon=False, loc="outside upper center", ncols=4)
    figure.savefig(path, dpi=150)


def _bars(axes, table, name: str, side: int, label: str, colour: str) -> None:
    figures = [getattr(row, name) for row in table]
    middle = [f.mean for f in figures]
    reach = [[f.mean - f.low for f in figures], [f.high - f.mean for f in figures]]
    places = [number + 0.18 * side for number in range(len(table))]
    axes.bar(places, middle, 0.34, yerr=reach, color=colour, ecolor="#444444", capsize=3, label=label)
