"""Tables II and III of [V]: centring errors, success and SAE of each method, with intervals, and what went wrong."""

import csv
from collections import Counter
from dataclasses import asdict, dataclass
from math import degrees
from pathlib import Path

import numpy as np

from tools.eval.bootstrap import interval
from tools.eval.episode import Episode
from tools.eval.judge import sae_terms


@dataclass(frozen=True, slots=True)
class Figure:
    """A mean and its 95 % interval."""

    mean: float
    low: float
    high: float

    @classmethod
    def of(cls, values, homes) -> "Figure":
        values = np.asarray(values, float)
        known = values[~np.isnan(values)]
        return cls(float(known.mean()) if len(known) else np.nan, *interval(values, homes))

    def show(self, form: str = "{:.2f}") -> str:
        if np.isnan(self.mean):
            return "-"
        return f"{form.format(self.mean)} [{form.format(self.low)}, {form.format(self.high)}]"


@dataclass(frozen=True, slots=True)
class Row:
    """One method under one condition. Errors are means over the successful episodes, as nothing else was centred."""

    method: str
    episodes: int
    success: Figure
    sae: Figure
    degrees: Figure
    pixels: Figure
    duration: Figure  # s
    claims: int
    right: int  # of the claims
    causes: dict[str, int]


def rows(episodes: list[Episode]) -> list[Row]:
    """A row for each method and condition, in the order of their first episode."""
    groups: dict[str, list[Episode]] = {}
    for episode in episodes:
        groups.setdefault(name_of(episode), []).append(episode)
    return [_row(name, mine) for name, mine in groups.items()]


def name_of(episode: Episode) -> str:
    """The row an episode belongs to: its method, and what was disturbed or replaced by the truth, if anything."""
    parts = episode.method, episode.disturbance, episode.truth and f"true {episode.truth}"
    return ", ".join(filter(None, parts))


def _row(method: str, episodes: list[Episode]) -> Row:
    homes = [e.home for e in episodes]
    success = [e.success for e in episodes]
    centred = [e for e in episodes if e.success]
    centred_homes = [e.home for e in centred]
    return Row(
        method,
        len(episodes),
        Figure.of(success, homes),
        Figure.of(sae_terms(success, [e.angular_error for e in episodes]), homes),
        Figure.of([degrees(e.angular_error) for e in centred], centred_homes),
        Figure.of([e.pixel_error for e in centred], centred_homes),
        Figure.of([e.duration for e in episodes], homes),
        sum(e.status == "found" for e in episodes),
        sum(e.status == "found" for e in centred),
        dict(Counter(e.cause for e in episodes if not e.success).most_common()),
    )


def margins(episodes: list[Episode], best: str = "vlpg-nav") -> dict[str, tuple[Figure, Figure]]:
    """What the method ``best`` has more of than each other row on the same questions: (success, SAE).

    Rows of other methods are compared under the same condition, and its own disturbed rows, or those that were told the
    truth, with the one that was neither.
    """
    table = {(name_of(e), e.home, e.noun): e for e in episodes}
    found = {}
    for other in dict.fromkeys(name_of(e) for e in episodes):
        method, _, condition = other.partition(", ")
        mine = best if method == best or not condition else f"{best}, {condition}"
        same = [e for e in episodes if name_of(e) == mine and (other, e.home, e.noun) in table]
        pairs = [(e, table[other, e.home, e.noun]) for e in same]
        if other == mine or not pairs:
            continue
        homes = [mine.home for mine, _ in pairs]
        parts = (
            ([e.success for e in side] for side in zip(*pairs)),
            (sae_terms([e.success for e in side], [e.angular_error for e in side]) for side in zip(*pairs)),
        )
        found[other] = tuple(Figure.of(np.subtract(*map(np.asarray, part), dtype=float), homes) for part in parts)
    return found


def show(episodes: list[Episode]) -> str:
    """The tables as text."""
    lines = [
        f"{'method':30} {'episodes':>8} {'success':>19} {'SAE':>19} {'degrees':>19} {'pixels':>22} {'claims right':>13}"
    ]
    for row in rows(episodes):
        lines.append(
            f"{row.method:30} {row.episodes:8d} {row.success.show():>19} {row.sae.show():>19} "
            f"{row.degrees.show('{:.1f}'):>19} {row.pixels.show('{:.1f}'):>22} {f'{row.right} of {row.claims}':>13}"
        )
    for row in rows(episodes):
        if row.causes:
            lines.append(f"{row.method} failed: " + "; ".join(f"{n} {cause}" for cause, n in row.causes.items()))
    for other, (success, weighted) in margins(episodes).items():
        more = f"{success.show('{:+.2f}')} more success and {weighted.show('{:+.2f}')} more SAE"
        lines.append(f"vlpg-nav has {more} than {other}, on the same questions")
    lines.append("In brackets: 95 % intervals over resampled homes. Errors are of the successful episodes.")
    return "\n".join(lines)


def write_csv(episodes: list, table: list, path: Path) -> None:
    """One line an episode; and beside that, as NAME-table.csv, one a row of the ``table``."""
    _write([asdict(episode) for episode in episodes], path)
    _write([_flat(row) for row in table], path.with_stem(f"{path.stem}-table"))


def _write(lines: list[dict], path: Path) -> None:
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, list(lines[0]) if lines else [])
        writer.writeheader()
        writer.writerows(lines)


def _flat(row) -> dict:
    """A row of a table without structure: a figure is a mean and the ends of its interval, causes are one text."""
    flat = {}
    for name, value in asdict(row).items():
        if name == "causes":
            flat[name] = "; ".join(f"{count} {cause}" for cause, count in value.items())
        elif isinstance(value, dict):
            flat |= {name: value["mean"], f"{name}_low": value["low"], f"{name}_high": value["high"]}
        else:
            flat[name] = value
    return flat
