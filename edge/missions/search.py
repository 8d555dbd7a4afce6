"""A mission that looks for one object and answers within a time limit: what all of them share."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from edge.missions.mission import Mission, Story
from edge.missions.motion import locate
from edge.missions.sighting import Sighting
from edge.observation import STOP, Observation, Twist
from edge.perception.prompts import Target
from edge.planning.local_search import Replan
from edge.planning.viewpoint import Viewpoint
from edge.robot import Robot

Status = Literal["found", "not found", "not in memory", "timeout", "lost"]


@dataclass(frozen=True, slots=True)
class Claim:
    """An object seen and centred, and how sure that is."""

    sighting: Sighting
    remembered: float  # the memory's best score there; without a memory, the sighting's own
    confidence: float  # probability that it is the object


@dataclass(frozen=True, slots=True)
class Outcome:
    """How the search ended."""

    status: Status
    claim: Claim | None  # the best one; when "not found", it was not good enough
    confidence: float  # probability that the object is where the claim, or else the first hypothesis, says
    duration: float  # s
    distance: float  # m
    hypotheses: list[Viewpoint] = field(default_factory=list)  # best first; the guesses when it is not in memory
    places: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))  # poses of the hits that hypotheses index
    replans: list[Replan] = field(default_factory=list)  # of the local searches


class Search(Mission):
    """Runs ``search``, a story that returns the ``Outcome``, and gives up when the time limit [s] has passed."""

    def __init__(self, robot: Robot, target: Target, time_limit: float):
        self.target = target
        self._limit = time_limit
        self.best: Claim | None = None  # of what it has centred so far
        self._started = self._driven = 0.0  # s, m; set by the first observation, as a new robot has read no clock yet
        super().__init__(robot)

    def search(self) -> Story:
        raise NotImplementedError

    def story(self) -> Story:
        self._started, self._driven = self.robot.stamp, self.robot.distance
        if not (yield from locate(self.robot)):
            return self.ended("lost")
        return (yield from self.search())

    def step(self, observation: Observation) -> Twist:
        twist = super().step(observation)
        if not self.done and self.elapsed > self._limit:
            self.outcome = self.ended("timeout", self.best)
            return STOP
        return twist

    @property
    def elapsed(self) -> float:
        """s since the question."""
        return self.robot.stamp - self._started

    def claim(self, centred: Sighting, remembered: float | None = None) -> Claim:
        """What was seen, beside the best score that the ``remembered`` views of it have, if there are any."""
        score = centred.detection.score
        remembered = score if remembered is None else remembered
        return Claim(centred, remembered, self.robot.encoder.confidence(score, remembered))

    def ended(self, status: Status, claim: Claim | None = None) -> Outcome:
        confidence = claim.confidence if claim else 0.0
        return Outcome(status, claim, confidence, self.elapsed, self.robot.distance - self._driven)
