"""A hard limit on a process's memory, to show that what was measured is enough."""

import os
import resource
from contextlib import suppress
from pathlib import Path

CGROUPS = Path("/sys/fs/cgroup")
RESERVED = 2 * 2**25  # bytes of address space that numpy's and OpenCV's OpenBLAS keep for matrices, and do not touch


class MemoryLimit:
    """So many MB for whoever calls ``enter``, between ``with`` and its end.

    A control group of the kernel's second kind where its memory controller may be used, as a service manager has it: it
    counts every page that the process is the first to use; of files, not what others have read before. Elsewhere
    RLIMIT_DATA, which counts what a process could write to of its own, heap and stacks, touched or not; files that are
    mapped do not count.
    """

    def __init__(self, megabytes: float):
        self._bytes = int(megabytes * 1e6)
        self._group: Path | None = None

    def __enter__(self) -> "MemoryLimit":
        group = CGROUPS / f"vlpg-bench-{os.getpid()}"
        try:
            if "memory" not in (CGROUPS / "cgroup.subtree_control").read_text().split():
                return self
            group.mkdir()
        except OSError:  # no such kernel, or not ours to use
            return self
        try:
            (group / "memory.max").write_text(str(self._bytes))
        except OSError:
            group.rmdir()
            return self
        self._group = group
        with suppress(OSError):  # a kernel without swap has no such file
            (group / "memory.swap.max").write_text("0")
        return self

    def __exit__(self, *error) -> None:
        if self._group is not None:
            with suppress(OSError):
                self._group.rmdir()

    @property
    def kind(self) -> str:
        if self._group is not None:
            return "control group"
        return f"RLIMIT_DATA, and {RESERVED / 1e6:.0f} MB of address space that two libraries keep untouched"

    @property
    def peak(self) -> float | None:
        """MB, the most that the group has taken by the kernel's count; None without one, or before Linux 5.19."""
        if self._group is None or not (self._group / "memory.peak").is_file():
            return None
        return int((self._group / "memory.peak").read_text()) / 1e6

    def enter(self) -> None:
        """Put the calling process under the limit."""
        if self._group is not None:
            (self._group / "cgroup.procs").write_text(str(os.getpid()))
        else:
            limit = self._bytes + RESERVED
            resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
