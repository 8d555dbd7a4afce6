"""What a robot that explores for an object knows: what its pictures promise, what is left to explore, where it saw it.

[U] Sec. IV. It decides where to go; the missions and the evaluation's discrete protocol go there, each in its own way.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from edge.mapping.frontiers import Frontier, frontiers
from edge.mapping.object_goal import ObjectGoal, Surface, surface
from edge.mapping.relevance import RelevanceMap
from edge.perception.detection import Detector, DetectorConfig
from edge.perception.encoder import View
from edge.perception.prompts import Target
from edge.planning.frontier_choice import Acquisition, ChoiceConfig, FrontierChoice
from edge.pose import has_moved
from edge.robot import Robot


@dataclass(frozen=True)
class ExplorationConfig:
    """What is worth a trip, and what is worth a closer look."""

    min_area: float = 1.5  # m2; smaller unknown pockets are no frontier, [U] Sec. IV
    noticed: float = 0.75  # two-prompt score of a picture taken on the way that is worth a closer look
    resembles: float = 0.3  # that score, from which a place is looked at when nothing is left to explore
    refuted: float = 1.0  # m around a place that was looked at closely in vain
    moved: float = 0.10  # m, or
    turned: float = np.radians(6.0)  # rad, before another picture tells something new: noise is not what errs most
    choice: ChoiceConfig = field(default_factory=ChoiceConfig)


class Likeness(NamedTuple):
    """A place that resembles the object in a picture."""

    score: float  # of that picture
    place: np.ndarray  # (2,) m
    seen: Surface


class Exploration:
    """Beliefs about one object in a home that is being discovered."""

    def __init__(
        self,
        robot: Robot,
        target: Target,
        prompts,
        acquisition: Acquisition,
        relevance: RelevanceMap | None = None,
        config: ExplorationConfig | None = None,
    ):
        """``prompts (P, D)`` are the vectors of the ensemble of [U] Table I for the target."""
        self.config = config or ExplorationConfig()
        self.target, self.prompts = target, np.asarray(prompts)
        self.relevance = relevance or RelevanceMap()
        self.choice = FrontierChoice(acquisition, self.config.choice)
        self.goal: ObjectGoal | None = None  # the object, as far as has been seen
        self._robot = robot
        self._detector = Detector(robot.encoder, DetectorConfig(min_score=self.config.resembles))
        self.alike: list[Likeness] = []  # by place, the picture of it that resembles the object most
        self._refuted: list[np.ndarray] = []  # (2,) m, what resembled the target only from afar
        self._considered: list[np.ndarray] = []  # (2,) m, places that were a goal because nothing else was left
        self._looked = np.array([1e9, 1e9, 0.0])  # pose of the last picture that the relevance map took in

    def take_in(self) -> None:
        """Heed the robot's newest picture, if there is one: what it promises, and whether it shows the object."""
        robot, frame = self._robot, self._robot.frame
        if frame is None or robot.localizer.lost:  # a lost robot knows not what place it looks at
            return
        view, pose = robot.view(), robot.in_map(frame.odom)
        if has_moved(self._looked, pose, self.config.moved, self.config.turned):
            self._looked = pose
            self.relevance.integrate(pose, frame.depth, self.promise(view), robot.camera, robot.grid)
        height, width = frame.depth.shape
        detection = self._detector.detect(view, self.target, (width, height))
        if detection is None:
            return
        seen = surface(detection, frame.depth, robot.camera, pose, robot.grid)
        self._compare(Likeness(detection.score, seen.centroid, seen))
        if detection.score >= self.config.noticed:
            self._notice(seen)

    def promise(self, view: View) -> np.ndarray:
        """Relevance in [0, 1] of what a picture shows, by each prompt: ``(P,)``."""
        return self._robot.encoder.relevance(self.prompts @ view.vectors[0])

    def _compare(self, new: Likeness) -> None:
        there, elsewhere = [], []
        for old in self.alike:
            (there if self._is_near(old.place, [new.place]) else elsewhere).append(old)
        if all(new.score > old.score for old in there):
            self.alike = [*elsewhere, new]

    def _notice(self, seen: Surface) -> None:
        if self.is_refuted(seen.centroid):
            return
        if self.goal is not None and self.goal.is_at(seen.centroid):
            self.goal.update(seen)
        elif self.goal is None or (self.goal.provisional and not seen.provisional and not self.is_settled()):
            self.goal = ObjectGoal(seen)

    def is_settled(self) -> bool:
        """Whether even a firm view of another thing is no reason to leave a goal whose end no view has shown."""
        return False

    def is_refuted(self, place) -> bool:
        """Whether ``place (2,)`` [m] was a goal in vain."""
        return self._is_near(place, self._refuted)

    def _is_near(self, place, places) -> bool:
        return any(_apart(place, other) <= self.config.refuted for other in places)

    def consider(self) -> bool:
        """Make the goal what resembles the object most of all places not looked at closely; whether there is one."""
        over = self._refuted + self._considered
        left = [alike for alike in self.alike if not self._is_near(alike.place, over)]
        if left:
            best = max(left, key=lambda alike: alike.score)
            self.goal = ObjectGoal(best.seen)
            self._considered.append(best.place)
        return bool(left)

    def refute(self) -> None:
        """The object is not there, or cannot be reached: nothing there counts any more. It may be behind that place."""
        self._refuted.append(self.goal.centroid)
        behind = self.goal.behind
        self.goal = None if behind is None or self.is_refuted(behind.centroid) else ObjectGoal(behind)

    def next_frontier(self) -> Frontier | None:
        """Where the acquisition function says that looking is most worth it; None when all has been looked at.

        Once the object seems to have been seen, and there is no way to it yet, what leads there.
        """
        robot = self._robot
        self.relevance.follow(robot.grid.frame)
        viewed = robot.coverage.viewed.view(bool) & ~robot.grid.unknown
        # Last, what only the lidar has seen of furniture.
        return self._choose(viewed) or self._choose(robot.coverage.explored(robot.grid, robot.config.radius))

    def _choose(self, explored: np.ndarray) -> Frontier | None:
        robot = self._robot
        found = frontiers(robot.grid, robot.pose, robot.config.radius, self.config.min_area, explored)
        if self.goal is not None:
            return self.choice.choose_toward(found, self.goal.nearest(robot.pose), robot.pose)
        return self.choice.choose(found, self.relevance, robot.pose)


def _apart(a, b) -> float:
    """m between two places (2,)."""
    return float(np.hypot(*(a - b)))
