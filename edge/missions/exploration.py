"""What a robot that explores for an object knows: what its pictures promise, what is left to explore, where it saw it.

[U] Sec. IV. It decides where to go; the missions and the evaluation's discrete protocol go there, each in its own way.
"""

from dataclasses import dataclass, field

import numpy as np

from edge.mapping.frontiers import Frontier, frontiers
from edge.mapping.object_goal import ObjectGoal, Surface, surface
from edge.mapping.relevance import RelevanceMap
from edge.perception.close_look import window_at
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
    certain: float = 0.9  # that score in a close look from near
    refuted: float = 1.0  # m around a place that was looked at closely in vain
    moved: float = 0.10  # m, or
    turned: float = np.radians(6.0)  # rad, before another picture tells something new: noise is not what errs most
    choice: ChoiceConfig = field(default_factory=ChoiceConfig)


@dataclass(frozen=True, slots=True)
class Candidate:
    """Something that a close look took for the object."""

    goal: ObjectGoal
    score: float  # of that look
    confidence: float  # that it is the object


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
        self.candidates: list[Candidate] = []  # that were looked at closely
        self._robot = robot
        self._detector = Detector(robot.encoder, DetectorConfig(min_score=0.0))
        self._most, self._alike = 0.0, None  # the highest score of a picture, and the Surface that had it
        self._closely = Detector(robot.encoder, DetectorConfig(min_score=self.config.certain))
        self._refuted: list[np.ndarray] = []  # (2,) m, what resembled the target only from afar
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
        score = self._detector.score(view, self.target)
        if score < min(self.config.noticed, self._most):
            return
        detection = self._detector.detect(view, self.target, (width, height))
        if detection is None:
            return
        seen = surface(detection, frame.depth, robot.camera, pose, robot.grid)
        if score > self._most and not self._is_refuted(seen.centroid):
            self._most, self._alike = score, seen
        if score >= self.config.noticed:
            self._notice(seen)

    def promise(self, view: View) -> np.ndarray:
        """Relevance in [0, 1] of what a picture shows, by each prompt: ``(P,)``."""
        return self._robot.encoder.relevance(self.prompts @ view.vectors[0])

    def _notice(self, seen: Surface) -> None:
        if self._is_refuted(seen.centroid):
            return
        if self.goal is not None and self.goal.is_at(seen.centroid):
            self.goal.update(seen)
        elif self.goal is None or (self.goal.provisional and not seen.provisional and not self._was_looked_at()):
            self.goal = ObjectGoal(seen)

    def _was_looked_at(self) -> bool:
        """Whether a close look took the goal for the object; a view of another thing is no reason then to leave it."""
        return any(candidate.goal is self.goal for candidate in self.candidates)

    def _is_refuted(self, place) -> bool:
        return any(np.hypot(*(place - other)) <= self.config.refuted for other in self._refuted)

    def look_closely(self) -> Candidate | None:
        """A closer look at the newest picture, four passes and one at what they show; None if the goal is not there.

        The goal moves to where that look says.
        """
        robot, frame = self._robot, self._robot.frame
        rgb, hfov, (height, width) = frame.rgb, robot.camera.hfov, frame.depth.shape
        views, last = robot.look_closely(), None
        for _ in range(2):
            found = [self._closely.detect(view, self.target, (width, height)) for view in views]
            best = max((d for d in found if d is not None), key=lambda d: d.score, default=last)
            if best is None:
                return None
            views, last = [robot.encoder.encode_image(rgb, hfov, window_at(best.centre, width, height))], best
        seen = surface(best, frame.depth, robot.camera, robot.in_map(frame.odom), robot.grid)
        if self.goal.is_at(seen.centroid):
            self.goal.update(seen)
            if seen.vague:  # it is not here, if anywhere that way
                return None
            self.candidates.append(Candidate(self.goal, best.score, robot.encoder.confidence(best.score, best.score)))
            return self.candidates[-1]
        if not self._is_refuted(seen.centroid):
            self.goal = ObjectGoal(seen)
        return None

    @property
    def best(self) -> Candidate | None:
        """The most probable of what was looked at closely."""
        return max(self.candidates, key=lambda candidate: candidate.confidence, default=None)

    def guess(self) -> ObjectGoal | None:
        """Where the picture that resembled the object most shows it, once; for when nothing was noticed anywhere."""
        seen, self._alike = self._alike, None
        return seen and ObjectGoal(seen)

    def refute(self) -> None:
        """The object is not there, or cannot be reached: nothing there counts any more. It may be behind that place."""
        self._refuted.append(self.goal.centroid)
        behind = self.goal.behind
        self.goal = None if behind is None or self._is_refuted(behind.centroid) else ObjectGoal(behind)

    def next_frontier(self) -> Frontier | None:
        """Where the acquisition function says that looking is most worth it; None when all has been looked at.

        Once the object seems to have been seen, and there is no way to it yet, what leads there.
        """
        robot = self._robot
        self.relevance.follow(robot.grid.frame)
        explored = robot.coverage.viewed.view(bool) & ~robot.grid.unknown
        found = frontiers(robot.grid, robot.pose, robot.config.radius, self.config.min_area, explored)
        if self.goal is not None:
            return self.choice.choose_toward(found, self.goal.nearest(robot.pose), robot.pose)
        return self.choice.choose(found, self.relevance, robot.pose)
