"""The four methods that [V] compares in Sec. IV, each a mission built from the same parts."""

from edge.missions.centring import centre
from edge.missions.find_object import Claim, FindObject, FindObjectConfig, Outcome
from edge.missions.map_home import MapHome
from edge.missions.mission import Mission, Story
from edge.missions.motion import drive
from edge.missions.sighting import sight
from edge.observation import STOP
from edge.perception.detection import Detector, DetectorConfig
from edge.perception.prompts import Target
from edge.robot import Robot
from tools.eval.tour import Tour, new_robot
from tools.eval.truth import finder

TIME_LIMIT = FindObjectConfig.time_limit  # s, the same for all


class Frontier(MapHome):
    """Baseline 1: no memory. Explore an unknown home by frontiers until a picture shows the object; centre it."""

    def __init__(self, robot: Robot, target: Target):
        self.target = target
        # Whoever looks at thousands of pictures needs a higher bar than 0.5 to stop for one.
        self.detector = Detector(robot.encoder, DetectorConfig(min_score=FindObjectConfig.in_memory))
        self._started = self._driven = 0.0  # set by the first observation: the robot is new, the world is not
        super().__init__(robot)

    def story(self) -> Story:
        robot = self.robot
        self._started, self._driven = robot.stamp, robot.distance
        for twist in super().story():
            yield twist
            if robot.frame is None:
                continue
            view = robot.encoder.encode_image(robot.frame.rgb, robot.camera.hfov)
            sighting = sight(robot, self.detector, self.target, [view])
            centred = sighting and (yield from centre(robot, self.detector, self.target, sighting))
            if centred:
                return self.ended("found", centred)
        return self.ended("not found")

    def step(self, observation):
        """One control step; gives up when the time limit has passed."""
        twist = super().step(observation)
        if not self.done and self.robot.stamp - self._started > TIME_LIMIT:
            self.outcome = self.ended("timeout")
            return STOP
        return twist

    def ended(self, status, sighting=None) -> Outcome:
        robot, claim, confidence = self.robot, None, 0.0
        if sighting is not None:
            score = sighting.detection.score
            confidence = robot.encoder.confidence(score, score)
            claim = Claim(sighting, score, confidence)
        duration, distance = robot.stamp - self._started, robot.distance - self._driven
        return Outcome(status, [], robot.memory.poses([]), claim, confidence, duration, distance)


class ViewpointOnly(FindObject):
    """Baseline 2: drive to the best viewpoint that the memory knows ([V] Eqs. 2 and 3), and stop there."""

    def story(self) -> Story:
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
    if method == "frontier":
        return Frontier(new_robot(tour.world, robot.encoder), target)
    if method == "vlpg-nav":
        return finder(tour, target, search, seed)
    return METHODS[method](robot, target, seed=seed)


METHODS = {
    "frontier": Frontier,
    "viewpoint": ViewpointOnly,
    "viewpoint+centring": ViewpointAndCentring,
    "vlpg-nav": FindObject,
}
