"""Find a named object in a known home: the whole of [V], Fig. 1."""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from edge.mapping.frontiers import reachable
from edge.missions.centring import centre
from edge.missions.evidence import Evidence, Place
from edge.missions.mission import Mission, Story
from edge.missions.motion import drive, face, look_from_near
from edge.missions.sighting import Sighting, sight, sight_things
from edge.observation import STOP
from edge.perception.close_look import look_closely
from edge.perception.detection import Detector
from edge.perception.prompts import Target
from edge.planning.local_search import LocalSearch
from edge.planning.viewpoint import Viewpoint, rank_viewpoints

Status = Literal["found", "not found", "not in memory", "timeout"]


@dataclass(frozen=True)
class FindObjectConfig:
    """How long and how far to look."""

    hits: int = 50  # k of [V] Sec. III-C
    hypotheses: int = 6  # viewpoints tried; [V] tries one. A right one is first for 3 in 10 names, among 6 for 6 in 10
    certain: float = 0.9  # score that needs no comparison with what the other viewpoints show
    in_memory: float = 0.5  # score of the best hit: some view beats something else; no higher limit tells the absent
    shown: float = 0.5  # score of a place worth a claim: the target beats what else it may be
    likely: float = 0.25  # score from afar that is worth a close look, which tells far more
    closer: int = 2  # things at a viewpoint that are looked at closely
    sweep: float = np.radians(40)  # rad to either side of the remembered bearing; half a field of view
    near: float = 1.5  # m from a thing, for a close look at it
    stand: float = 2.2  # m from the target, where centring begins: nearer, what is beside it leaves the picture
    pictures: int = 4  # looked at while standing still
    things: int = 4  # looked at in one picture, a pass of the image tower each
    last_call: float = 60.0  # s before the time limit, when the search ends and the best place is approached
    time_limit: float = 300.0  # s, [V] Sec. IV


@dataclass(frozen=True, slots=True)
class Outcome:
    """How the search ended."""

    status: Status
    hypotheses: list[Viewpoint]  # best first; the best guesses when the object is not in memory
    places: np.ndarray  # (N, 3) poses of the memory's hits, which the hypotheses' members index
    sighting: Sighting | None  # the last one, when found
    duration: float  # s
    distance: float  # m
    searches: list[np.ndarray] = field(default_factory=list)  # (R, C) probability maps, one a replan


class FindObject(Mission):
    """Ask the memory, look at the likely things at its best viewpoints, go to the one that fits best, centre it."""

    def __init__(self, robot, target: Target, search_unknown: bool = False, seed: int = 0, config=None):
        """``search_unknown`` goes to the best guesses even if the object does not seem to be in memory."""
        self.config = config or FindObjectConfig()
        self.target = target
        self.detector = Detector(robot.encoder)
        self.search_unknown = search_unknown
        self.hypotheses: list[Viewpoint] = []
        self.places = np.zeros((0, 3))
        self.evidence = Evidence()
        self.searches: list[np.ndarray] = []
        self._rng = np.random.default_rng(seed)
        self._started, self._driven = robot.stamp, robot.distance
        super().__init__(robot)

    def story(self) -> Story:
        self.hypotheses = self.recall()
        if not self.search_unknown and not self.remembered():
            return self.ended("not in memory")
        left = self.hypotheses[: self.config.hypotheses]
        while left and not self.certain() and not self.late():
            hypothesis = self.next_of(left)
            left = [other for other in left if other is not hypothesis]
            yield from self.inspect(hypothesis)
        for place in self.evidence.ranked(self.config.shown):
            if (centred := (yield from self.approach(place))) is not None:
                return self.ended("found", centred)
        return self.ended("not found")

    def next_of(self, hypotheses: list[Viewpoint]) -> Viewpoint:
        """The best one first; after it the nearest, as all will be compared in the end."""
        if len(hypotheses) == self.config.hypotheses:
            return hypotheses[0]
        return min(hypotheses, key=lambda hypothesis: np.hypot(*(hypothesis.pose - self.robot.pose)[:2]))

    def inspect(self, hypothesis: Viewpoint) -> Story:
        """Look from a viewpoint, then closely at what is likely; where the memory is certain, else around it, too."""
        yield from drive(self.robot, hypothesis.pose[:2], heading=hypothesis.pose[2])
        yield from self.look()
        likely = [place for place in self.evidence.ranked(self.config.likely) if not place.closely]
        for place in likely[: self.config.closer]:
            if not self.certain() and not self.late():
                yield from self.look_closely_at(place)
        remembered = self._scores[hypothesis.members].max() >= self.config.certain
        if remembered and not self.evidence.ranked(self.config.shown):
            yield from self.search_nearby(hypothesis)

    def look_closely_at(self, place: Place) -> Story:
        """Go near a thing and look at it again."""
        place.closely = True
        yield from look_from_near(self.robot, place.nearest.position, self.config.near)
        yield from self.stare()

    def approach(self, place: Place) -> Story:
        """Go to a place and centre the thing there; the last ``Sighting``, with the score of all, or None if lost."""
        for position in (place.nearest.position, place.nearest.behind):
            if position is not None:
                yield from look_from_near(self.robot, position, self.config.stand)
                first = replace(place.sighting, position=position)
                centred = yield from centre(self.robot, self.detector, self.target, first)
                if centred is not None:
                    return replace(centred, detection=replace(centred.detection, score=place.score))
        return None

    def certain(self) -> bool:
        """Whether some place needs no comparison any more."""
        return bool(self.evidence.ranked(self.config.certain))

    def late(self) -> bool:
        """Whether the time left is needed to approach the best place."""
        return self.robot.stamp - self._started > self.config.time_limit - self.config.last_call

    def recall(self) -> list[Viewpoint]:
        """Viewpoints from which the memory says that the object was seen, best first ([V] Eqs. 2 and 3)."""
        robot = self.robot
        hits = robot.memory.search(self.target.direction, self.config.hits)
        self.places = robot.memory.poses(hits.ids)
        self.places[:, 2] += hits.bearings  # a region's hit looks where the region does
        self._scores = self.detector.softmax(hits.scores)
        return rank_viewpoints(self.places, self._scores, robot.grid.occupied, robot.grid.frame, robot.camera)

    def remembered(self) -> bool:
        """Whether some view shows the object, as far as the encoder can tell."""
        return bool(self.hypotheses) and self._scores.max() > self.config.in_memory

    def look(self) -> Story:
        """Look ahead, then to both sides until certain."""
        heading = self.robot.pose[2]
        for side in (0.0, self.config.sweep, -self.config.sweep):
            yield from face(self.robot, heading + side)
            yield from self.stare()
            if self.certain():
                break

    def stare(self) -> Story:
        """Stand still and look at each thing in some pictures; what depth does not show apart, in parts of them."""
        robot, shown = self.robot, False
        for picture in range(self.config.pictures):
            yield STOP
            if robot.frame is not None:
                first = picture * self.config.things
                for sighting in sight_things(robot, self.detector, self.target, self.config.things, first):
                    shown |= self.evidence.add(sighting).score >= self.config.shown
        if not shown and robot.frame is not None:
            views = look_closely(robot.encoder, robot.frame.rgb, hfov=robot.camera.hfov)
            sighting = sight(robot, self.detector, self.target, views)
            if sighting is not None:
                self.evidence.add(sighting)

    def search_nearby(self, hypothesis: Viewpoint) -> Story:
        """Local search around a viewpoint that did not show the object ([V] Sec. III-E)."""
        robot, grid = self.robot, self.robot.grid
        search = LocalSearch(
            grid.occupied,
            grid.free,
            grid.frame,
            robot.pose,
            self.places[hypothesis.members],
            self._scores[hypothesis.members],
            robot.camera,
        )
        search.observed(robot.pose)
        while True:
            can_reach = reachable(grid, robot.pose, robot.config.radius)
            pose = search.next_pose(robot.pose, can_reach, grid.clearance(), grid.frame, self._rng)
            if pose is None or self.late():
                return
            self.searches.append(search.probability.copy())
            yield from drive(robot, pose[:2], heading=pose[2])
            yield from self.stare()
            if self.evidence.ranked(self.config.shown):
                return
            search.observed(robot.pose)

    def step(self, observation):
        """One control step; gives up when the time limit has passed."""
        twist = super().step(observation)
        if not self.done and self.robot.stamp - self._started > self.config.time_limit:
            self.outcome = self.ended("timeout")
            return STOP
        return twist

    def ended(self, status: Status, sighting: Sighting | None = None) -> Outcome:
        duration, distance = self.robot.stamp - self._started, self.robot.distance - self._driven
        return Outcome(status, self.hypotheses, self.places, sighting, duration, distance, self.searches)
