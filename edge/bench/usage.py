"""Proportional set size (PSS) of processes over time, from ``/proc/<pid>/smaps_rollup``."""

import re
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

MB = 1e6  # bytes
_FIELD = re.compile(rb"^(Pss|Pss_Anon|Pss_File|Pss_Shmem|Rss):\s+(\d+) kB", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Usage:
    """One reading [MB]. Pages that k processes share count 1/k for each, so readings of several processes add up."""

    pss: float
    anonymous: float  # heap, stacks, copied pages
    file_backed: float  # mapped files (libraries, weights) and shared memory; the kernel can drop or page these
    rss: float


@dataclass
class History:
    """Readings of one process."""

    times: list[float] = field(default_factory=list)  # s since the sampler started
    usages: list[Usage] = field(default_factory=list)

    @property
    def peak(self) -> Usage | None:
        """The reading with the highest PSS."""
        return max(self.usages, key=lambda usage: usage.pss, default=None)


def read_usage(pid: int) -> Usage | None:
    """One reading, or None when the process is gone or is not ours to look at."""
    try:
        content = Path(f"/proc/{pid}/smaps_rollup").read_bytes()
    except OSError:
        return None
    sizes = {name.decode(): int(kilobytes) * 1024 / MB for name, kilobytes in _FIELD.findall(content)}
    if "Pss" not in sizes:  # a zombie has no memory map any more
        return None
    shared = sizes.get("Pss_Shmem", 0.0)
    return Usage(sizes["Pss"], sizes.get("Pss_Anon", 0.0), sizes.get("Pss_File", 0.0) + shared, sizes["Rss"])


class Sampler:
    """Reads every process each ``period`` [s] in a thread of its own, between ``with`` and its end.

    A peak that lasts less than the period may be missed.
    """

    def __init__(self, pids: dict[str, int], period: float | None = 0.5):
        """With a ``period`` of None they are read once."""
        self.pids = dict(pids)
        self.period = period
        self.histories = {name: History() for name in pids}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="memory sampler", daemon=True)

    def __enter__(self) -> "Sampler":
        self._thread.start()
        return self

    def __exit__(self, *error) -> None:
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        started = time.monotonic()
        while True:
            now = time.monotonic() - started
            for name, pid in self.pids.items():
                usage = read_usage(pid)
                if usage is not None:
                    self.histories[name].times.append(round(now, 2))
                    self.histories[name].usages.append(usage)
            if self._stop.wait(self.period):
                return
