"""What the user sees while the robot works: a bar on a terminal, a line now and then in a log."""

import time
from collections import deque

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn


class TimeLeft:
    """Wall time until the rest of the seen floor has been looked at, at the recent pace.

    The lidar sees a room before the camera has looked at it, so the floor that is left is known in part only: the
    estimate may grow when a door opens on another room.
    """

    def __init__(self, window: float = 30.0):
        """The pace is that of the last ``window`` [s]."""
        self._window = window
        self._readings: deque[tuple[float, float]] = deque()

    def update(self, now: float, viewed: float, area: float) -> float | None:
        """Seconds left, from ``viewed`` of ``area`` [m2]; None while there is no pace to judge by."""
        self._readings.append((now, viewed))
        while now - self._readings[0][0] > self._window:
            self._readings.popleft()
        then, before = self._readings[0]
        if now - then < 2.0 or viewed - before < 0.1:
            return None
        return max(area - viewed, 0.0) * (now - then) / (viewed - before)


class Display:
    """Shows one activity at a time; ``with`` keeps a terminal's live line in order."""

    def __init__(self, console: Console, every: float = 10.0):
        """Without a terminal, a line is printed each ``every`` [s]."""
        self.console, self._every, self._last = console, every, time.monotonic()
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(bar_width=30),
            TextColumn("{task.fields[detail]}"),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._task = self._progress.add_task("", total=None, detail="")

    def __enter__(self) -> "Display":
        self._progress.start()
        return self

    def __exit__(self, *error) -> None:
        self._progress.stop()

    def show(self, activity: str, detail: str, share: float | None = None) -> None:
        """``share`` in [0, 1] fills the bar; None lets it pulse."""
        total = None if share is None else 1.0
        self._progress.update(self._task, description=activity, detail=detail, total=total, completed=share or 0.0)
        if not self.console.is_terminal and time.monotonic() - self._last >= self._every:
            self._last = time.monotonic()
            self.say(f"{activity}: {detail}")

    def say(self, line: str, style: str | None = None) -> None:
        """A line that stays."""
        self.console.print(line, style=style, highlight=False, markup=False, soft_wrap=True)
