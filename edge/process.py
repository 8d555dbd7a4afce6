"""What a process needs from the operating system: to be stopped politely, and to know how much memory it uses."""

import re
import signal
import threading
import time
from pathlib import Path

_ROLLUP = Path("/proc/self/smaps_rollup")


def stop_event():
    """An Event that SIGTERM and SIGINT set. Only from the main thread."""
    event = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: event.set())
    return event


class MemoryUse:
    """Proportional set size (PSS) of this process, sampled: what it would free by ending, shared pages by share."""

    PERIOD = 2.0  # s between samples; reading takes about a millisecond

    def __init__(self):
        self.now = self.peak = 0.0  # MB
        self._next = 0.0
        self.sample()

    def sample(self):
        """Reads it if the last reading is older than ``PERIOD``."""
        if time.monotonic() < self._next:
            return
        self._next = time.monotonic() + self.PERIOD
        self.now = pss()
        self.peak = max(self.peak, self.now)


def pss():
    """PSS of this process [MB of 10^6 bytes]; 0 where the kernel does not tell."""
    try:
        found = re.search(r"^Pss:\s+(\d+) kB", _ROLLUP.read_text(), re.MULTILINE)
    except OSError:
        return 0.0
    return int(found[1]) * 1024 / 1e6 if found else 0.0
