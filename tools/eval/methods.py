"""The four methods that [V] compares in Sec. IV, and exploring as [U] does: missions built from the same parts."""

from edge.missions.centring import centre
from edge.missions.explore_for_object import ExploreForObject
from edge.missions.find_object import FindObject, FindObjectConfig
from edge.missions.map_home import MapHome
from edge.missions.mission import Mission, Story
from edge.missions.motion import drive
from edge.missions.search import Search
from edge.missions.sighting import sight
from edge.observation import STOP
from edge.perception.detection import Detector, DetectorConfig
from edge.perception.prompts import Target
from edge.robot import Robot
from tools.eval.tour import Tour, new_robot
from tools.eval.truth import finder


class Frontier(Search):
    """Baseline 1: no memory. Explore an unknown home by frontiers until a picture shows the object; centre it."""

    def __init__(self, robot: Robot, target: Target):
        # Whoever looks at thousands of pictures needs a higher bar than 0.5 to stop for one.
        self.detector = Detector(robot.encoder, DetectorConfig(min_score=FindObjectConfig.in_memory))
        super().__init__(robot, target, FindObjectConfig.time_limit)

    def search(self) -> Story:
        robot = self.robot
        for twist in MapHome(robot).story():
            yield twist
            if robot.frame is None:
                continue
            view = robot.encoder.encode_image(robot.frame.rgb, robot.camera.hfov)
            sighting = sight(robot, self.detector, self.target, [view])
            centred = sighting and (yield from centre(robot, self.detector, self.target, sighting))
            if centred:
                return self.ended("found", self.claim(centred))
        return self.ended("not found")


class ViewpointOnly(FindObject):
    """Baseline 2: drive to the best viewpoint that the memory knows ([V] Eqs. 2 and 3), and stop there."""

    def search(self) -> Story:
        self.hypotheses = self.recall()
        if not self.hypotheses:
            return self.ended("not found")
        best = self.hypotheses[0]
        yield from drive(self.robot, best.pose[:2], heading=best.pose[2])
        return (yield from self.arrived())

    def arrived(self) -> Story:
        """Nothing more; it never doubts."""
        yield STOP
        return self.ended("found")


class ViewpointAndCentring(ViewpointOnly):
    """Baseline 3: at the viewpoint, look ahead; if the object is detected, drive up to it and centre it."""

    def arrived(self) -> Story:
        sighting = yield from self.spotter.stare()
        if sighting is not None:
            yield from centre(self.robot, self.spotter.detector, self.target, sighting)
        return self.ended("found")


def mission_for(method: str, tour: Tour, target: Target, search: bool, seed: int) -> Mission:
    """The mission of a ``method`` in METHODS. ``search``: VLPG-Nav looks even for what is not in its memory."""
    robot = tour.robot
    if method in WITHOUT_MEMORY:
        return WITHOUT_MEMORY[method](new_robot(tour.world, robot.encoder), target)
    if method == "vlpg-nav":
        return finder(tour, target, search, seed)
    return METHODS[method](robot, target, seed=seed)


WITHOUT_MEMORY = {"frontier": Frontier, "explore": ExploreForObject}
METHODS = {
    **WITHOUT_MEMORY,
    "viewpoint": ViewpointOnly,
    "viewpoint+centring": ViewpointAndCentring,
    "vlpg-nav": FindObject,
}
