"""Find a named object in a home never seen before: frontiers in the order of what the pictures promise ([U])."""

from dataclasses import dataclass, field, replace

import numpy as np

from edge.mapping.frontiers import Frontier
from edge.missions.centring import centre
from edge.missions.exploration import Exploration, ExplorationConfig
from edge.missions.mission import Story, until
from edge.missions.motion import drive, locate, look_from_near, route, turn
from edge.missions.search import Claim, Outcome, Search, Status
from edge.missions.spotter import Spotter
from edge.perception.prompts import Target, ensemble
from edge.planning.acquisition import upper_confidence_bound


@dataclass(frozen=True)
class ExploreConfig:
    """How long to explore, and what counts as found."""

    sure: float = 0.5  # confidence of a claim that ends the search; others are compared when all has been looked at
    claimed: float = 0.2  # confidence below which the answer is "not found"
    beside: float = 0.9  # m from the object's nearest point to the floor that a way must lead to
    rechoose: float = 1.0  # s; a better frontier may have come into view
    time_limit: float = 600.0  # s; [U] allows 500 actions
    enough: float = 480.0  # s, after which the best claim so far is the answer
    exploration: ExplorationConfig = field(default_factory=ExplorationConfig)


class ExploreForObject(Search):
    """Drive to the frontier with the highest upper confidence bound, and to what seems to be the object, until it is.

    What is seen on the way fills the memory, as on any tour: the next question about this home is one for it.
    """

    def __init__(self, robot, target: Target, config: ExploreConfig | None = None):
        self.config = config or ExploreConfig()
        prompts = robot.encoder.encode_text(ensemble(target.name))
        self.exploration = Exploration(robot, target, prompts, _bound, config=self.config.exploration)
        self.spotter = Spotter(robot, target)
        super().__init__(robot, target, self.config.time_limit)

    def search(self) -> Story:
        robot = self.robot
        robot.coverage.forget()
        robot.grid.forget_contacts()
        robot.memory.begin_tour()
        sure = yield from self.explore()
        if robot.localizer.lost:
            return self.ended("lost", self.best)
        if self.best is None or self.best.confidence < self.config.claimed:
            return self.ended("not found", self.best)
        if not sure:
            centred = yield from self.spotter.approach(self.best.sighting)
            self.best = self.best if centred is None else replace(self.best, sighting=centred)
        return self.ended("found", self.best)

    def ended(self, status: Status, claim: Claim | None = None) -> Outcome:
        return replace(super().ended(status, claim), replans=self.spotter.replans)

    def explore(self) -> Story:
        """Look around, go from frontier to frontier, then to what resembles the object; whether a claim is sure."""
        robot, around = self.robot, False
        sure = yield from self.watching(turn(robot, 2 * np.pi))
        while not sure and self.elapsed < self.config.enough and (yield from locate(robot)):
            if (frontier := self.exploration.next_frontier()) is not None:
                sure, around = (yield from self.watching(self.visit(frontier))), False
            elif not around:  # or did something only stand in the way?
                sure, around = (yield from self.watching(turn(robot, 2 * np.pi))), True
            elif self.exploration.consider():
                sure = yield from self.pursue()
            else:
                break
        return sure

    def watching(self, action: Story) -> Story:
        """Do that, and heed every picture meanwhile; whether it led to a claim that is sure.

        After a false alarm the robot stands elsewhere: the rest of what it was about to do is left.
        """
        for twist in action:
            yield twist
            self.exploration.take_in()
            if self.exploration.goal is not None:
                return (yield from self.pursue())
        return False

    def pursue(self) -> Story:
        """Go to what seems to be the object, or else to what is behind it; whether that is a claim that is sure."""
        while self.exploration.goal is not None and self.elapsed < self.config.enough:
            claim = yield from self.reach()
            if claim is not None and (self.best is None or claim.confidence > self.best.confidence):
                self.best = claim
            if claim is not None and claim.confidence >= self.config.sure:
                return True
            if self.robot.localizer.lost:  # that is nothing against the place
                self.exploration.goal = None
            else:
                self.exploration.refute()
        return False

    def visit(self, frontier: Frontier) -> Story:
        """Drive to a frontier as long as it is the best; there, look around if it still is one."""
        rechoose = self.robot.stamp + self.config.rechoose

        def beaten():
            nonlocal rechoose
            if self.robot.stamp < rechoose:
                return False
            rechoose += self.config.rechoose
            best = self.exploration.next_frontier()
            return best is None or not self.exploration.choice.is_same(best.waypoint, frontier.waypoint)

        arrived = yield from until(beaten, drive(self.robot, frontier.waypoint))
        if arrived is False and not self.robot.localizer.lost:
            self.exploration.choice.drop(frontier.waypoint)
        elif arrived:
            yield from until(beaten, turn(self.robot, 2 * np.pi))

    def reach(self) -> Story:
        """Drive to what seems to be the object, look closely from near, and centre it: a ``Claim``, or None."""
        robot = self.robot
        while route(robot, self.exploration.goal.nearest(robot.pose), near=self.config.beside) is None:
            frontier = self.exploration.next_frontier()
            if frontier is None or robot.localizer.lost:
                return None
            for twist in self.visit(frontier):
                yield twist
                self.exploration.take_in()
        goal = self.exploration.goal
        for twist in look_from_near(robot, goal.nearest(robot.pose), self.spotter.config.near):
            yield twist
            self.exploration.take_in()
        if not goal.is_at(self.exploration.goal.centroid):  # a firm view of another thing took its place
            return (yield from self.reach())
        sighting = yield from self.spotter.look()
        centred = sighting and (yield from centre(robot, self.spotter.detector, self.target, sighting))
        return centred and self.claim(centred)


def _bound(means, variances, distances):
    return upper_confidence_bound(means, variances)
