"""What a process needs from the operating system: to be stopped politely, and to use and know little memory."""

import ctypes
import os
import re
import signal
import threading
import time
from pathlib import Path

_ROLLUP, _SMAPS = Path("/proc/self/smaps_rollup"), Path("/proc/self/smaps")
_MAPPING = re.compile(
    r"^([0-9a-f]+-[0-9a-f]+ \S+ \S+ \S+ \S+) *(.*)\n(?:(?![0-9a-f]+-).*\n)*?Anonymous: +(\d+) kB", re.M
)
_MADV_DONTNEED = 4  # <sys/mman.h>

# glibc's malloc.h. Blocks from this size on, such as pictures and the towers' activations, get pages of their own.
_M_MMAP_THRESHOLD, _LARGE = -3, 128 * 1024  # bytes; glibc's own first value
_M_TOP_PAD, _SPARE = -2, 16 * 1024  # bytes that the heap grows by beyond what is asked for; glibc takes 128 kB


def stop_event():
    """An Event that SIGTERM and SIGINT set. Only from the main thread."""
    event = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        # Not in the handler: it interrupts the main thread, which may hold the event's lock as it waits for it.
        signal.signal(number, lambda *_: threading.Thread(target=event.set).start())
    return event


def give_back_large_blocks():
    """From now on, a large block that is freed goes back to the system at once.

    By itself glibc raises its threshold to the largest block ever freed, up to 32 MB; then pictures and activations
    come from the heap, where one small block that outlives them keeps their pages: tens of MB in a minute of mapping.
    Elsewhere than on glibc this does nothing.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _LARGE)
        mallopt(_M_TOP_PAD, _SPARE)


def give_back_what_loading_took():
    """Unmaps code and weights; what is still used is mapped again, page by page, when it is used next.

    Loading a library touches most of it, and the kernel maps the pages around each one that is touched, too: of 47 MB
    of code a mission needs 23. They stay in the page cache, so that taking one back costs microseconds. Pages that are
    this process's own, as those with corrected addresses, are left alone. Elsewhere than on Linux this does nothing.
    """
    madvise = getattr(ctypes.CDLL(None), "madvise", None)
    if madvise is None or not _SMAPS.exists():
        return
    madvise.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    for start, end in _of_files_alone(_SMAPS.read_text()):
        madvise(start, end - start, _MADV_DONTNEED)


def _of_files_alone(smaps):
    """Start and end of each mapping in the text of ``smaps`` all of whose pages are a file's, as it is on disk."""
    for head, name, own in _MAPPING.findall(smaps):
        span, mode = head.split()[:2]
        if mode.startswith("r-") and name.startswith("/") and int(own) == 0:
            yield tuple(int(address, 16) for address in span.split("-"))


def cache_file(name):
    """Path of a file that may be lost at any time: ``$XDG_CACHE_HOME/vlpg/NAME``, else ``~/.cache/vlpg/NAME``.

    None for a user without a home folder, as services may be. Nothing is made.
    """
    folder = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(folder):  # unset, or to be ignored by the XDG base directory specification
        folder = os.path.expanduser("~/.cache")
    return Path(folder) / "vlpg" / name if os.path.isabs(folder) else None


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
