"""A mission is a story told one control step at a time."""

from collections.abc import Callable, Generator

from edge.observation import STOP, Observation, Twist
from edge.robot import Robot

# Yields the command of each step, returns how the story ended.
Story = Generator[Twist, None, object]


class Mission:
    """Steps a story. ``outcome`` is None while it goes on, then what the story returned.

    The story is a generator: each ``yield`` is one control step, after which ``self.robot`` has perceived
    the next observation. So a mission reads top to bottom, though it runs 100 ms at a time.
    """

    def __init__(self, robot: Robot):
        self.robot = robot
        self.outcome = None
        self._story = self.story()

    def story(self) -> Story:
        raise NotImplementedError

    @property
    def done(self) -> bool:
        return self.outcome is not None

    def step(self, observation: Observation) -> Twist:
        """Take in one observation and answer with the command for the next 100 ms; STOP once done."""
        self.robot.perceive(observation)
        if self.done:
            return STOP
        try:
            return next(self._story)
        except StopIteration as end:
            self.outcome = end.value
            return STOP


def until(met: Callable[[], bool], action: Story) -> Story:
    """``action``, broken off after the step in which the condition is ``met``; its result, None if broken off."""
    while True:
        try:
            twist = next(action)
        except StopIteration as end:
            return end.value
        yield twist
        if met():
            return None
