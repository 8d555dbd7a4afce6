"""The same work done by several programs, side by side: each weighed in a process of its own, then timed in turns."""

from contextlib import ExitStack
from dataclasses import dataclass
from math import ceil

import numpy as np

from edge.bench.probe_process import ProbeProcess

PASSES = 3  # a turn, at least; one more runs before them untimed, as the one before has filled the caches
TURN = 0.03  # s that a turn of ours takes, at least: a tenth of a millisecond is not known from three passes
TURNS = 30


@dataclass(frozen=True)
class Peer:
    """What one of them took: times [ms], how many times ours it took, and its peak PSS [MB] and parts of it."""

    name: str
    p50: float
    p10: float
    p90: float
    ratio: float
    peak: float
    anonymous: float
    file_backed: float


def measure(commands: dict[str, tuple[str, ...]], turns: int = TURNS) -> list[Peer]:
    """Weigh each probe alone, ours first, then time all in turns. Raises ProbeFailed when one does not run."""
    memory = {}
    for name, command in commands.items():
        with ProbeProcess(*command) as probe:
            memory[name] = probe.peak
    times: dict[str, list[list[float]]] = {name: [] for name in commands}
    with ExitStack() as stack:
        probes = {name: stack.enter_context(ProbeProcess(*command)) for name, command in commands.items()}
        once = np.median(next(iter(probes.values())).time(PASSES))
        passes = max(PASSES, ceil(TURN / once))
        for _ in range(turns):
            for name, probe in probes.items():
                times[name].append(probe.time(passes + 1)[1:])
    milliseconds = {name: 1e3 * np.array(turns) for name, turns in times.items()}
    per_turn = {name: np.median(values, 1) for name, values in milliseconds.items()}
    first = per_turn[next(iter(commands))]
    found = []
    for name, values in milliseconds.items():
        p10, p50, p90 = np.percentile(values, [10, 50, 90])
        # In pairs, turn by turn: the load of the machine changes between turns, less so within one.
        ratio = float(np.median(per_turn[name] / first))
        peak = memory[name]
        figures = (p50, p10, p90, ratio, peak.pss, peak.anonymous, peak.file_backed)
        found.append(Peer(name, *(round(float(figure), 2) for figure in figures)))
    return found


def show(found: list[Peer]) -> str:
    """A table."""
    lines = [f"{'one thread':36} {'p50':>8} {'p10 - p90':>17} {'x ours':>7} {'peak PSS':>9} {'anon + file':>12}"]
    for peer in found:
        spread, parts = f"{peer.p10:.2f} - {peer.p90:.2f}", f"{peer.anonymous:.0f} + {peer.file_backed:.0f}"
        figures = f"{peer.p50:5.2f} ms {spread:>14} ms {peer.ratio:6.2f}x {peer.peak:6.1f} MB {parts:>9} MB"
        lines.append(f"{peer.name:36} {figures}")
    return "\n".join(lines)
