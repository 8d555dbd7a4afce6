"""The other end of a probe: starts it in a fresh process, weighs it while it loads and runs, and has it time passes."""

import json
import os
import re
import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from tools.demo.memory import MB, Sampler, Usage

_OWN = re.compile(r"/(site-packages|dist-packages|models)/")  # in the path of a mapped file
_ONE_THREAD = {
    "ORT_DISABLE_TELEMETRY": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
}  # fmt: skip


class ProbeFailed(RuntimeError):
    """A probe ended; the message has its last words."""


class ProbeProcess:
    """A running probe, between ``with`` and its end. ``module`` names what to run, as ``tools.models.probe``."""

    PERIOD = 0.004  # s between two readings of the memory; what takes a megabyte for less is missed

    def __init__(self, module: str, *arguments: str):
        """Starts it and waits until it is ready. Raises ProbeFailed when it ends instead."""
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", module, *map(str, arguments)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | _ONE_THREAD,
        )
        with Sampler({"probe": self._process.pid}, self.PERIOD) as sampler:
            self._answer()
        peak = sampler.histories["probe"].peak
        if peak is None:
            self.__exit__()
            raise ProbeFailed("the kernel does not tell how much memory a process has (/proc/<pid>/smaps_rollup)")
        others = _borne_by_others(self._process.pid)
        # [MB] of loading and the first passes
        self.peak: Usage = replace(peak, pss=peak.pss + others, file_backed=peak.file_backed + others)

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

    def time(self, passes: int) -> list[float]:
        """Durations [s] of that many passes, one after another."""
        self._process.stdin.write(f"{passes}\n")
        self._process.stdin.flush()
        return json.loads(self._answer())

    def _answer(self) -> str:
        line = self._process.stdout.readline()
        if not line:
            said = self._process.stderr.read().strip().splitlines() or ["it said nothing"]
            self.__exit__()
            raise ProbeFailed(f"the process that was to be measured ended: {said[-1]}")
        return line


def _borne_by_others(pid: int) -> float:
    """MB of the process's own libraries and weights that PSS charges to other processes because they map them, too.

    The measuring process is one of them, a robot that runs meanwhile another. On a robot there is nobody else: those
    files count in full. What belongs to the system (libc, the interpreter) stays shared.
    """
    counted, others = False, 0  # kB
    for line in Path(f"/proc/{pid}/smaps").read_text().splitlines():
        if re.match(r"^[0-9a-f]+-", line):
            counted = bool(_OWN.search(line))
        elif counted and line.startswith(("Rss:", "Pss:")):
            others += int(line.split()[1]) * (1 if line.startswith("Rss:") else -1)
    return others * 1024 / MB
