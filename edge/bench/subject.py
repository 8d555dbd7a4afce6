"""What the measured processes have in common: each does its work, tells how long its stages took, and waits.

While it waits it is weighed once more: that is its steady size.
"""

import json
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence

from edge.process import give_back_large_blocks, give_back_what_loading_took


def begin() -> None:
    """Be a process as the robot's is, on one core."""
    give_back_large_blocks()
    give_back_what_loading_took()
    pin()


def pin() -> None:
    """Keep this process on one core: the last one, as the first have the machine's own work."""
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def timed(function: Callable[[int], object], calls: int, warm: int = 3) -> list[float]:
    """Times [s] of ``function(0)``, ``function(1)`` …, after ``warm`` calls that do not count."""
    times = []
    for call in range(-warm, calls):
        started = time.perf_counter()
        function(max(call, 0))
        times.append(time.perf_counter() - started)
    return times[warm:]


def tell(stages: Mapping[str, Sequence[float]], sizes: dict[str, float] | None = None) -> None:
    """Give the times [s] of the calls of each stage, and ``sizes`` [MB], to the measuring process; end with stdin.

    Stage by stage: this process is weighed, and what it has to say is no part of the robot.
    """
    out = sys.stdout
    out.write('{"stages": {')
    for number, (stage, calls) in enumerate(stages.items()):
        milliseconds = [round(1000 * call, 4) for call in calls]
        out.write(", " * (number > 0) + json.dumps(stage) + ": " + json.dumps(milliseconds))
    out.write('}, "sizes": ' + json.dumps(sizes or {}) + "}\n")
    out.flush()
    sys.stdin.read()
