"""The other end of a probe: starts it in a fresh process, weighs it while it loads and runs, and has it time passes."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from edge.bench.usage import MB, Sampler, Usage, read_usage

# In the path of a mapped file: packages, weights, and the interpreter, which seldom runs anything else on a robot.
_OWN = re.compile(r"/(site-packages|dist-packages|site|models|lib-dynload)/|/(lib)?python3[^/]*$")
_ONE_THREAD = {
    "ORT_DISABLE_TELEMETRY": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
}  # fmt: skip


class ProbeFailed(RuntimeError):
    """A probe ended; the message has its last words."""


class ProbeProcess:
    """A running probe, between ``with`` and its end. ``module`` names what to run, as ``tools.models.probe``."""

    PERIOD = 0.004  # s between two readings of the memory; what takes a megabyte for less is missed

    def __init__(
        self,
        module: str,
        *arguments: str,
        period: float | None = PERIOD,
        limit: Callable[[], None] | None = None,
        flags: tuple[str, ...] = (),
    ):
        """Starts it and waits until it is ready, which is when it prints a line: ``said``.

        ``period`` [s] is between readings of its memory, which hold it up: None where it is to be timed. ``limit`` is
        called in the process before it begins. ``flags`` are Python's. Raises ProbeFailed when it ends instead.
        """
        self._process = subprocess.Popen(
            [sys.executable, *flags, "-P", "-m", module, *map(str, arguments)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | _ONE_THREAD,
            preexec_fn=limit,
        )
        with Sampler({"probe": self._process.pid}, period) as sampler:
            self.said = self._answer()
        usages = sampler.histories["probe"].usages
        if not usages:
            self.__exit__()
            raise ProbeFailed("the kernel does not tell how much memory a process has (/proc/<pid>/smaps_rollup)")
        self.peak: Usage = self._alone(max(usages, key=lambda usage: usage.rss))  # [MB] until it was ready

    def __enter__(self) -> "ProbeProcess":
        return self

    def __exit__(self, *error) -> None:
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        self._process.stderr.close()

    @property
    def now(self) -> Usage:
        """[MB] at this moment."""
        return self._alone(read_usage(self._process.pid))

    def time(self, passes: int) -> list[float]:
        """Durations [s] of that many passes, one after another."""
        self._process.stdin.write(f"{passes}\n")
        self._process.stdin.flush()
        return json.loads(self._answer())

    def _alone(self, usage: Usage) -> Usage:
        """What the reading were if nobody else ran this program.

        PSS charges a part of a process's libraries and weights to others that map them, too: to this one, which
        measures, or to a robot that runs meanwhile. On a robot there is nobody else. What belongs to the system (libc,
        OpenSSL) stays shared.
        """
        pss = usage.rss - _borne_by_the_system(self._process.pid)
        return replace(usage, pss=pss, file_backed=pss - usage.anonymous)

    def _answer(self) -> str:
        line = self._process.stdout.readline()
        if not line:
            said = self._process.stderr.read().strip().splitlines()
            self.__exit__()
            code = self._process.returncode
            how = f"signal {-code}" if code < 0 else f"exit code {code}"  # 9: the kernel's, when memory runs out
            raise ProbeFailed(f"the process that was to be measured ended: {said[-1] if said else how}")
        return line


def _borne_by_the_system(pid: int) -> float:
    """MB of files that are not the program's own, which PSS charges to other processes because they map them, too."""
    own, others = False, 0  # kB
    for line in Path(f"/proc/{pid}/smaps").read_text().splitlines():
        if re.match(r"^[0-9a-f]+-", line):
            own = bool(_OWN.search(line))
        elif not own and line.startswith(("Rss:", "Pss:")):
            others += int(line.split()[1]) * (1 if line.startswith("Rss:") else -1)
    return others * 1024 / MB
