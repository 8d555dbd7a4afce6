"""Tour a home, known or not: drive until the camera has looked at every reachable part, and remember the views."""

from dataclasses import dataclass

import numpy as np

from edge.mapping.frontiers import Frontier, frontiers
from edge.missions.mission import Mission, Story, until
from edge.missions.motion import drive, length, locate, route, turn
from edge.pose import wrap


@dataclass(frozen=True)
class MapHomeConfig:
    """When a home counts as mapped, and what a tour tries first."""

    min_area: float = 0.15  # m2 that nobody has looked at; enough for a ball behind a door post
    considered: int = 4  # nearest frontiers whose true path is planned before choosing
    turn_cost: float = 0.5  # m per rad: a quarter turn costs about the time of 0.8 m
    given_up: float = 0.4  # m around a waypoint that could not be seen, not to be tried again
    time_limit: float = 900.0  # s


@dataclass(frozen=True, slots=True)
class HomeMapped:
    """How a tour ended."""

    complete: bool  # all was looked at that it could get to; False: time ran out, it is lost, or no picture came
    duration: float  # s
    distance: float  # m
    area: float  # m2 of free floor
    nodes: int  # in the memory


class MapHome(Mission):
    """Frontier exploration, the mapping run of [V] Sec. III-A, where *explored* is what the camera has looked at.

    The lidar sees a room from its door; the memory needs the camera to have been near. In a home that was mapped
    before, the map stays and everything is looked at again, so that the memory learns what has changed.
    """

    def __init__(self, robot, config: MapHomeConfig | None = None):
        self.config = config or MapHomeConfig()
        self._given_up: list[np.ndarray] = []
        super().__init__(robot)

    def story(self) -> Story:
        robot, started, driven = self.robot, self.robot.stamp, self.robot.distance
        robot.coverage.forget()
        robot.grid.forget_contacts()
        robot.memory.begin_tour()
        complete = False
        if (yield from locate(robot)):
            complete = yield from until(lambda: robot.stamp - started > self.config.time_limit, self.tour())
        duration, distance = robot.stamp - started, robot.distance - driven
        return HomeMapped(bool(complete), duration, distance, robot.grid.area, len(robot.memory))

    def tour(self) -> Story:
        """Look around, then go from frontier to frontier; whether all has been looked at that there is a way to."""
        robot = self.robot
        yield from turn(robot, 2 * np.pi)
        while (frontier := self.next_frontier()) is not None:
            yield from self.visit(frontier)
        # Who is lost, or gets no pictures, finds no frontiers either.
        return bool(robot.coverage.viewed.any()) and not robot.localizer.lost

    def next_frontier(self) -> Frontier | None:
        """The frontier that is soonest reached, or None when all has been seen that can be."""
        robot = self.robot
        explored = robot.coverage.explored(robot.grid, robot.config.radius)
        found = frontiers(robot.grid, robot.pose, robot.config.radius, self.config.min_area, explored)
        found = [frontier for frontier in found if not self._is_given_up(frontier.waypoint)]
        found.sort(key=lambda frontier: np.hypot(*(frontier.waypoint - robot.pose[:2])))
        best, least = None, np.inf
        for frontier in found[: self.config.considered]:
            path = route(robot, frontier.waypoint)
            if path is None:
                self._given_up.append(frontier.waypoint)
                continue
            ahead = path[1] - robot.pose[:2]
            turning = abs(wrap(np.arctan2(ahead[1], ahead[0]) - robot.pose[2]))
            cost = length(path) + self.config.turn_cost * turning
            if cost < least:
                best, least = frontier, cost
        # The nearest ones may all have been dropped just now while others remain.
        return self.next_frontier() if best is None and found else best

    def visit(self, frontier: Frontier) -> Story:
        """Drive towards a frontier until it has been looked at; there, turn once around if need be."""
        robot, waypoint = self.robot, frontier.waypoint
        for action in (drive(robot, waypoint), turn(robot, 2 * np.pi)):
            for twist in action:
                if robot.coverage.has_explored(robot.grid, robot.config.radius, waypoint):
                    return
                yield twist
        self._given_up.append(waypoint)

    def _is_given_up(self, waypoint) -> bool:
        return any(np.hypot(*(waypoint - other)) < self.config.given_up for other in self._given_up)
