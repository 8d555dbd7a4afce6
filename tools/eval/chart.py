"""Success and SAE of the methods as a picture."""

from pathlib import Path

from tools.eval.episode import Episode
from tools.eval.table import rows


def draw(episodes: list[Episode], path: Path) -> None:
    """Bars with 95 % intervals, one pair a method; the file's ending chooses the format."""
    from matplotlib.figure import Figure

    table = rows(episodes)
    figure = Figure(figsize=(1.2 + 1.6 * len(table), 3.6), layout="constrained")
    axes = figure.subplots()
    for shift, name, colour in ((-0.18, "success", "#2a6f97"), (0.18, "sae", "#e09f3e")):
        figures = [getattr(row, name) for row in table]
        middle = [f.mean for f in figures]
        reach = [[f.mean - f.low for f in figures], [f.high - f.mean for f in figures]]
        places = [number + shift for number in range(len(table))]
        label = "SAE" if name == "sae" else "success"
        axes.bar(places, middle, 0.34, yerr=reach, color=colour, ecolor="#444444", capsize=3, label=label)
    axes.set_xticks(range(len(table)), [row.method for row in table])
    axes.set_ylim(0, 1)
    axes.set_ylabel("share of episodes")
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(frameon=False, loc="outside upper center", ncols=2)
    figure.savefig(path, dpi=150)
