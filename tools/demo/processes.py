"""Child processes that end with their parent, whatever ends it, and whose logs say why one died early."""

import ctypes
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

_PR_SET_PDEATHSIG = 1
_LIBC = ctypes.CDLL(None)  # loaded here: nothing may be loaded between fork and exec
ENVIRONMENT = {"ORT_DISABLE_TELEMETRY": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"}


class ProcessDied(RuntimeError):
    """A process ended that should have gone on. The message has its last words."""


class Child:
    """One running command; everything it prints goes to ``log``."""

    def __init__(self, name: str, argv: list[str], log: Path):
        self.name, self.log = name, Path(log)
        with self.log.open("wb") as stream:
            self._process = subprocess.Popen(
                argv,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                # A cache of its own: a run must not depend on what earlier ones left in the user's.
                env=os.environ | ENVIRONMENT | {"XDG_CACHE_HOME": str(self.log.parent.resolve())},
                start_new_session=True,  # Ctrl-C reaches the parent only, which then stops its children in order
                preexec_fn=_die_with_parent,
            )

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """None while it runs; negative: the signal that ended it."""
        return self._process.poll()

    def check(self) -> None:
        """Raises ProcessDied with the last lines of the log when it no longer runs."""
        code = self.exit_code
        if code is not None:
            how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
            last = self.last_lines() or "(it printed nothing)"
            raise ProcessDied(f"The {self.name} process {how}. Its last words, from {self.log}:\n{last}")

    def last_lines(self, count: int = 12) -> str:
        lines = self.log.read_text(errors="replace").splitlines()
        return "\n".join(f"  {line}" for line in lines[-count:])

    def stop(self, patience: float = 5.0) -> None:
        """Ask it to end, and after ``patience`` [s] end it. Does nothing when it has ended already."""
        if self.exit_code is None:
            self._process.terminate()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


class Supervisor:
    """Starts children between ``with`` and its end, and stops all of them there, the last started first."""

    def __init__(self, folder: Path):
        """Logs go to ``folder/<name>.log``."""
        self.folder = Path(folder)
        self.children: list[Child] = []

    def __enter__(self) -> "Supervisor":
        return self

    def __exit__(self, *error) -> None:
        for child in reversed(self.children):
            child.stop()

    def start(self, name: str, argv: list[str]) -> Child:
        child = Child(name, argv, self.folder / f"{name}.log")
        self.children.append(child)
        return child

    def check(self) -> None:
        """Raises ProcessDied when any child has ended."""
        for child in self.children:
            child.check()

    def watch(self, seconds: float) -> None:
        """Let ``seconds`` pass; raises ProcessDied as soon as a child ends."""
        until = time.monotonic() + seconds
        while True:
            self.check()
            left = until - time.monotonic()
            if left <= 0:
                return
            time.sleep(min(left, 0.1))


def module(name: str, *arguments: str) -> list[str]:
    """Command line that runs an installed module, and never one of the same name in the current folder."""
    return [sys.executable, "-P", "-m", name, *arguments]


def free_port() -> int:
    """A TCP port of the loopback interface that nobody listens on now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def _die_with_parent() -> None:
    """Runs in the child before exec: should the parent be killed outright, the kernel ends the child too."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
