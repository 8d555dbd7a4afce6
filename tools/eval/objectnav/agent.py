"""A robot that explores for an object by the discrete actions of [U] Sec. V."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from edge.mapping.object_goal import ObjectGoal
from edge.missions.exploration import Exploration
from edge.missions.motion import route
from edge.observation import Observation
from edge.pose import wrap
from edge.robot import Robot
from tools.eval.objectnav.actions import FORWARD, TURN, Action

Ending = Literal["", "found", "explored", "out of actions"]


@dataclass(frozen=True)
class AgentConfig:
    """The protocol's numbers, and when a sighting counts."""

    actions: int = 500  # [U] Sec. V
    stop: float = 0.9  # m from the object's nearest point
    near: float = 1.8  # m from it, where it is looked for closely; nearer, a camera 0.88 m high loses what lies low
    facing: float = np.radians(20.0)  # rad off the axis, at most, for a close look
    sure: float = 0.5  # confidence of a close look that ends the search; less is compared with what else turns up
    reserve: int = 100  # actions kept for the way to the best of that


class Agent:
    """Turns once around, then goes to frontiers until it sees the object, and to that; ``ending``: how it ended."""

    def __init__(self, robot: Robot, exploration: Exploration, config: AgentConfig | None = None):
        self.config = config or AgentConfig()
        self.robot, self.exploration = robot, exploration
        self.ending: Ending = ""
        self.actions = 0
        self.path: np.ndarray | None = None  # (K, 2) m, to where it goes now
        self._story = self._explore()

    def act(self, observation: Observation) -> Action:
        """Take in what the last action has shown, and choose the next."""
        self.robot.perceive(observation)
        self.exploration.take_in()
        action = next(self._story) if self.actions < self.config.actions else self._end("out of actions")
        self.actions += 1
        return action

    def _explore(self) -> Iterator[Action]:
        exploration, last = self.exploration, self.config.actions - self.config.reserve
        for _ in range(round(2 * np.pi / TURN)):
            yield "left"
        while True:
            best = exploration.best
            if exploration.goal is not None:
                yield from self._reach()
            elif best and self.actions >= last:
                yield from self._settle_for(best.goal)
            elif (frontier := exploration.next_frontier()) is None:
                yield from self._settle_for(best.goal if best else exploration.guess())
            elif (action := self.toward(frontier.waypoint)) is not None:
                yield action
            elif self.path is None:
                exploration.choice.drop(frontier.waypoint)
            else:  # there, and it is still a frontier: the camera has not looked beyond it
                yield "left"

    def toward(self, place, near: float = 0.4) -> Action | None:
        """The action that leads to ``place (2,)`` [m] or to within ``near`` of it; None there, or without a way."""
        self.path = route(self.robot, place, near)
        if self.path is None:
            return None
        offsets = self.path - self.robot.pose[:2]
        beyond = np.flatnonzero(np.hypot(*offsets.T) > FORWARD)
        if not len(beyond):
            return None
        step = offsets[beyond[0]]
        away = float(wrap(np.arctan2(step[1], step[0]) - self.robot.pose[2]))
        if abs(away) > TURN / 2:
            return "left" if away > 0 else "right"
        return "forward"

    def _reach(self) -> Iterator[Action]:
        """Point-goal navigation to the object; it is looked at closely from near, and only what is sure counts."""
        sought, confirmed = self.exploration.goal, False
        while (goal := self.exploration.goal) is sought:
            distance, bearing = self._offset(goal)
            if distance < self.config.near and abs(bearing) <= self.config.facing and not confirmed:
                found = self.exploration.look_closely()
                confirmed = found is not None and found.confidence >= self.config.sure
            action = self.toward(goal.nearest(self.robot.pose), self.config.stop)
            if self.path is None and (frontier := self.exploration.next_frontier()) is not None:
                action = self.toward(frontier.waypoint) or "left"
            if distance > self.config.stop and action is not None:
                yield action
            elif confirmed:
                yield self._end("found")
            elif abs(bearing) > TURN / 2:
                yield "left" if bearing > 0 else "right"
            elif self.exploration.goal is sought:
                self.exploration.refute()

    def _settle_for(self, goal: ObjectGoal | None) -> Iterator[Action]:
        """To the best guess: the object is here, as the protocol promises."""
        while goal is not None:
            distance, _ = self._offset(goal)
            action = self.toward(goal.nearest(self.robot.pose), self.config.stop)
            if distance <= self.config.stop or action is None:
                yield self._end("found")
            yield action
        yield self._end("explored")

    def _offset(self, goal: ObjectGoal) -> tuple[float, float]:
        """Distance [m] and bearing [rad] of the goal's nearest point."""
        x, y = goal.nearest(self.robot.pose) - self.robot.pose[:2]
        return float(np.hypot(x, y)), float(wrap(np.arctan2(y, x) - self.robot.pose[2]))

    def _end(self, ending: Ending) -> Action:
        self.ending = ending
        return "stop"
