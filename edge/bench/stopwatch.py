"""How long the stages of the robot take, measured where they are called."""

import time
from array import array
from collections import defaultdict
from functools import partial


class Stopwatch:
    """Takes the times [s] of calls, by the name of their stage, until they are read."""

    def __init__(self):
        self._calls: dict[str, array] = defaultdict(partial(array, "d"))

    def watch(self, owner, method: str, stage: str) -> None:
        """From now on, time each call of ``owner``'s ``method``; ``owner`` is an object, a class or a module."""
        function = getattr(owner, method)

        def timed(*arguments, **options):
            started = time.perf_counter()
            try:
                return function(*arguments, **options)
            finally:
                self._calls[stage].append(time.perf_counter() - started)

        setattr(owner, method, timed)

    def read(self) -> dict[str, array]:
        """The calls since the last reading."""
        calls, self._calls = dict(self._calls), defaultdict(partial(array, "d"))
        return calls
