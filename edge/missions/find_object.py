"""Find a named object in a known home: the whole of [V], Fig. 1."""

from dataclasses import dataclass, replace
from random import Random

import numpy as np

from edge.mapping.frontiers import reachable
from edge.memory.recall import recall
from edge.missions.mission import Story
from edge.missions.motion import drive
from edge.missions.search import Claim, Outcome, Search, Status
from edge.missions.spotter import Spotter
from edge.perception.detection import Detector, DetectorConfig
from edge.perception.prompts import Target
from edge.planning.local_search import LocalSearch, Replan
from edge.planning.viewpoint import Viewpoint, rank_viewpoints


@dataclass(frozen=True)
class FindObjectConfig:
    """How long and how far to look."""

    hits: int = 50  # k of [V] Sec. III-C
    hypotheses: int = 3  # viewpoints tried, best first; [V] tries one
    certain: float = 0.9  # score of the memory from which the object is searched for around where it was seen
    sure: float = 0.5  # confidence of a claim that needs no comparison with what the other viewpoints show
    claimed: float = 0.2  # confidence below which the answer is "not found"
    in_memory: float = 0.75  # score of the best hit; of objects that were seen, nine in ten have more
    alike: float = 0.5  # of the best hit's dot product; a sighting may be weaker than the memory, but not by more
    given_up: float = 1.0  # m around a place that could not be driven to, not to be tried again
    time_limit: float = 300.0  # s, [V] Sec. IV
    enough: float = 200.0  # s, after which the best claim so far is the answer; the way back to it takes up to a minute


class FindObject(Search):
    """Ask the memory, go to the best viewpoint, look, centre; else search nearby, then try the next hypothesis.

    Beyond [V], which stops at the first viewpoint: unless a claim is sure, those from all hypotheses are compared, and
    the best is the answer if it is probable enough.
    """

    def __init__(self, robot, target: Target, search_unknown: bool = False, seed: int = 0, config=None):
        """``search_unknown`` goes to the best guesses even if the object does not seem to be in memory, and answers
        with the best of them, however improbable.
        """
        self.config = config or FindObjectConfig()
        self.spotter = Spotter(robot, target)
        self.search_unknown = search_unknown
        self.hypotheses: list[Viewpoint] = []
        self.places = np.zeros((0, 3))
        self._rng = Random(seed)
        super().__init__(robot, target, self.config.time_limit)

    def search(self) -> Story:
        self.hypotheses = self.recall()
        if not self.search_unknown and not self.remembered():
            return self.ended("not in memory")
        here = None
        for hypothesis in self.hypotheses[: self.config.hypotheses]:
            sighting = yield from self.inspect(hypothesis)
            centred = sighting and (yield from self.spotter.approach(sighting))
            here = centred and self.claim(centred, float(self._scores[hypothesis.members].max()))
            if here and (self.best is None or here.confidence > self.best.confidence):
                self.best = here
            if self.best and self.best.confidence >= self.config.sure or self.elapsed > self.config.enough:
                break
        if self.best is None and self.search_unknown and self.hypotheses:
            return (yield from self.guess())
        if self.best is None or self.best.confidence < self.config.claimed and not self.search_unknown:
            return self.ended("not found", self.best)
        if self.best is not here:
            self.best = yield from self.go_back(self.best)
        return self.ended("found", self.best)

    def inspect(self, hypothesis: Viewpoint) -> Story:
        """Look from a viewpoint; where the memory is certain of the object, and it is not there, around it, too."""
        yield from drive(self.robot, hypothesis.pose[:2], heading=hypothesis.pose[2])
        sighting = yield from self.spotter.look()
        if sighting is None and self._scores[hypothesis.members].max() >= self.config.certain:
            sighting = yield from self.search_nearby(hypothesis)
        return sighting

    def guess(self) -> Story:
        """Nothing was recognized from anywhere: what resembled the object most is the view in memory."""
        first = self.hypotheses[0]
        yield from drive(self.robot, first.pose[:2], heading=first.pose[2])
        return self.ended("found")

    def go_back(self, claim: Claim) -> Story:
        """To the best claim, as other places were looked at since; the ``Claim``, renewed if it is seen again."""
        centred = yield from self.spotter.approach(claim.sighting)
        return claim if centred is None else replace(claim, sighting=centred)

    def recall(self) -> list[Viewpoint]:
        """Viewpoints from which the memory says that the object was seen, best first ([V] Eqs. 2 and 3)."""
        robot, grid = self.robot, self.robot.grid
        self._remembered = grid.occupied, grid.free, grid.frame  # the home, as far as the memory's views tell
        hits = recall(robot.memory, self.target.direction, self.config.hits, robot.camera)
        self.places = robot.memory.poses(hits.ids)
        self.places[:, 2] += hits.bearings  # a region's hit looks where the region does
        self._scores = self.spotter.detector.softmax(hits.scores)
        weakest = self.spotter.detector.softmax(self.config.alike * hits.scores.max(initial=0.0))
        self.spotter.detector = Detector(robot.encoder, DetectorConfig(min(float(weakest), self.config.certain)))
        return rank_viewpoints(self.places, self._scores, grid.occupied, grid.frame, robot.camera)

    def remembered(self) -> bool:
        """Whether some view shows the object, as far as the encoder can tell."""
        return bool(self.hypotheses) and self._scores.max() > self.config.in_memory

    def search_nearby(self, hypothesis: Viewpoint) -> Story:
        """Local search around a viewpoint that did not show the object ([V] Sec. III-E): a ``Sighting`` or None."""
        robot = self.robot
        search = LocalSearch(
            *self._remembered,
            hypothesis.pose,
            self.places[hypothesis.members],
            self._scores[hypothesis.members],
            robot.camera,
        )
        search.notice(robot.grid.occupied, robot.grid.frame)
        for pose in self.spotter.in_vain:
            search.observed(pose)
        given_up = []
        while self.elapsed < self.config.enough:
            grid = robot.grid
            ground = reachable(grid, robot.pose, robot.config.radius)
            for place in given_up:
                ground &= ~grid.frame.within(self.config.given_up, place)
            pose = search.next_pose(robot.pose, ground, grid.clearance(), grid.frame, self._rng)
            if pose is None:
                return None
            self.spotter.replans.append(Replan(search.frame, search.probability.copy(), pose))
            if not (yield from drive(robot, pose[:2], heading=pose[2])):
                given_up.append(pose[:2])
            sighting = yield from self.spotter.stare()
            if sighting is not None:
                return sighting
            search.notice(robot.grid.occupied, robot.grid.frame)
            search.observed(self.spotter.in_vain[-1])
        return None

    def ended(self, status: Status, claim: Claim | None = None) -> Outcome:
        outcome = super().ended(status, claim)
        confidence = outcome.confidence
        if claim is None and status != "not found" and self.hypotheses:  # not seen, or not looked for
            remembered = float(self._scores[self.hypotheses[0].members].max())
            confidence = self.robot.encoder.confidence(remembered, remembered)
        return replace(
            outcome, confidence=confidence, hypotheses=self.hypotheses, places=self.places, replans=self.spotter.replans
        )
