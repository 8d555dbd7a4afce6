"""A robot that explores for an object by the discrete actions of [U] Sec. V."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from edge.mapping.frontiers import reachable
from edge.mapping.object_goal import ObjectGoal
from edge.missions.motion import route
from edge.observation import Observation
from edge.planning.standpoint import stands_before
from edge.pose import wrap
from edge.robot import Robot
from tools.eval.objectnav.actions import FORWARD, TURN, Action
from tools.eval.objectnav.candidates import CandidateExploration

# "guessed": nothing is sure, and the protocol promises that the thing is somewhere.
Ending = Literal["", "found", "guessed", "explored", "out of actions"]


@dataclass(frozen=True)
class AgentConfig:
    """The protocol's numbers, and when a sighting counts."""

    actions: int = 500  # [U] Sec. V
    stop: float = 0.9  # m from the object's nearest point, and
    slack: float = 0.1  # m further that a robot which has stopped may turn out to be
    beside: float = 2.0  # m from it, where ground that is not known yet may lead to it
    near: float = 1.8  # m from it, where it is looked for closely; nearer, a camera 0.88 m high loses what lies low
    facing: float = np.radians(20.0)  # rad off the axis, at most, for a close look
    sure: float = 0.4  # confidence of a close look that ends the search: more is right as seldom, and takes longer
    reserve: int = 100  # actions kept for the way to the best of that


class Agent:
    """Turns once around, then goes to frontiers until it sees the object, and to that; ``ending``: how it ended."""

    def __init__(self, robot: Robot, exploration: CandidateExploration, config: AgentConfig | None = None):
        self.config = config or AgentConfig()
        self.robot, self.exploration = robot, exploration
        self.ending: Ending = ""
        self.actions = 0
        self.path: np.ndarray | None = None  # (K, 2) m, to where it goes now
        self.aim: ObjectGoal | None = None  # what it takes for the object, in the end
        self._story = self._explore()

    def act(self, observation: Observation) -> Action:
        """Take in what the last action has shown, and choose the next."""
        self.robot.perceive(observation)
        self.exploration.take_in()
        if self.actions == self.config.actions:
            return self._end("out of actions")
        self.actions += 1
        return next(self._story)

    def _explore(self) -> Iterator[Action]:
        exploration, last = self.exploration, self.config.actions - self.config.reserve
        for _ in range(round(2 * np.pi / TURN)):
            yield "left"
        while True:
            if self.actions >= last:
                yield from self._settle_for(exploration.guesses)
            elif exploration.goal is not None:
                yield from self._reach(last)
            elif (frontier := exploration.next_frontier()) is None:
                if not exploration.consider():
                    yield from self._settle_for(exploration.guesses)
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
        away = np.hypot(*offsets.T)
        beyond = np.flatnonzero(away > FORWARD)
        if not len(beyond) and away[-1] <= FORWARD / 2:
            return None
        step = offsets[beyond[0] if len(beyond) else -1]
        away = float(wrap(np.arctan2(step[1], step[0]) - self.robot.pose[2]))
        if abs(away) > TURN / 2:
            return self._turn(away)
        return "forward"

    def _reach(self, last: int) -> Iterator[Action]:
        """Point-goal navigation to the object; it is looked at closely from near, and only what is sure counts.

        At action ``last`` it turns to what it is surest of.
        """
        config, sought = self.config, self.exploration.goal
        looked = confirmed = arrived = False
        while (goal := self.exploration.goal) is sought and (confirmed or self.actions < last):
            distance, bearing = self._offset(goal)
            if distance < config.near and not looked and abs(bearing) > config.facing:
                yield self._turn(bearing)  # nearer still, what lies low would leave the picture
                continue
            if distance < config.near and abs(bearing) <= config.facing and not confirmed:
                found, looked = self.exploration.look_closely(), True
                confirmed = found is not None and found.confidence >= config.sure
            action, before = self._approach(goal)
            near_enough = distance <= config.stop + (config.slack if arrived else 0.0)
            arrived = action is None or (before and near_enough)
            if not arrived:
                yield action
            elif confirmed and (near_enough or self.path is not None):
                yield self._end("found", goal)
            elif abs(bearing) > TURN / 2:
                yield self._turn(bearing)
            elif self.exploration.goal is sought:
                self.exploration.refute()

    def _approach(self, goal: ObjectGoal) -> tuple[Action | None, bool]:
        """The action that leads to before the goal, None there, and whether the robot is on its side of all walls.

        While no ground before it is known, to what may show some: near to it as the crow flies may be in another room.
        """
        place, stand = goal.nearest(self.robot.pose), self._stand(goal)
        if stand is not None:
            return self.toward(stand, 0.0), bool(np.hypot(*(stand - self.robot.pose[:2])) <= FORWARD)
        frontier = self.exploration.next_frontier()
        if frontier is None or np.hypot(*(frontier.waypoint - place)) > self.config.beside:
            action = self.toward(place, self.config.stop)  # it may be amid a table
            if self.path is not None or frontier is None:
                return action, True
        return self.toward(frontier.waypoint) or "left", False

    def _stand(self, goal: ObjectGoal) -> np.ndarray | None:
        """The nearest known ground (2,) [m] to stop on before the goal; None while there is none."""
        robot, place = self.robot, goal.nearest(self.robot.pose)
        ground = reachable(robot.grid, robot.pose, robot.config.radius)
        for near in (self.config.stop - FORWARD / 2, self.config.stop):  # it stops up to a step before it is there
            stands = stands_before(place, goal.origin, near, ground, robot.grid.occupied, robot.grid.frame)
            if len(stands):
                return stands[np.hypot(*(stands - robot.pose[:2]).T).argmin()]
        return None

    def _settle_for(self, guesses: list[ObjectGoal]) -> Iterator[Action]:
        """To the best guess that there is a way to: the object is here, as the protocol promises."""
        for goal in guesses:
            while (action := self._to(goal)) is not None:
                yield action
            if self.path is not None or self._offset(goal)[0] <= self.config.stop:
                yield self._end("guessed", goal)
        yield self._end("explored")

    def _to(self, goal: ObjectGoal) -> Action | None:
        """The action that leads to before the goal; None there, or without a way."""
        stand = self._stand(goal)
        if stand is not None:
            return self.toward(stand, 0.0)
        if self._offset(goal)[0] <= self.config.stop:
            return None
        return self.toward(goal.nearest(self.robot.pose), self.config.stop)

    def _turn(self, bearing: float) -> Action:
        return "left" if bearing > 0 else "right"

    def _offset(self, goal: ObjectGoal) -> tuple[float, float]:
        """Distance [m] and bearing [rad] of the goal's nearest point."""
        x, y = goal.nearest(self.robot.pose) - self.robot.pose[:2]
        return float(np.hypot(x, y)), float(wrap(np.arctan2(y, x) - self.robot.pose[2]))

    def _end(self, ending: Ending, aim: ObjectGoal | None = None) -> Action:
        self.ending, self.aim = ending, aim
        return "stop"
