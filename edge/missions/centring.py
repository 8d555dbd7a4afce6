"""Drive up to an object in view and bring it to the middle of the picture ([V] Sec. III-D, Eqs. 4-6)."""

from dataclasses import dataclass

import numpy as np

from edge.missions.mission import Story
from edge.missions.motion import route
from edge.missions.sighting import Sighting, sight
from edge.observation import STOP
from edge.perception.detection import Detector
from edge.perception.prompts import Target
from edge.perception.tracking import BoxTracker
from edge.planning.centring import ImageTarget
from edge.planning.mpepc import Mpepc
from edge.robot import Robot


@dataclass(frozen=True)
class CentringConfig:
    """When the approach ends."""

    patience: float = 2.0  # s without the object in a picture, after which it is lost
    replan_every: float = 1.0  # s
    standoff: float = 1.5  # m from the object's place to the nearest floor that the way there may end at
    time_limit: float = 30.0  # s; a noisy box may never settle within the tolerance, and near enough is good


CONFIG = CentringConfig()


def centre(
    robot: Robot, detector: Detector, sought: Target, first: Sighting, config: CentringConfig = CONFIG
) -> Story:
    """Approach until near and centred; the last ``Sighting``, or None when the object was lost on the way."""
    controller = Mpepc(camera=robot.camera)
    tracker = BoxTracker()
    column, _ = tracker.update(first.stamp, first.detection.centre)
    last, started, planned = first, robot.stamp, -np.inf
    while not controller.arrived and robot.stamp - started < config.time_limit:
        seen = sight(robot, detector, sought)
        if seen is not None:
            last = seen
        elif robot.stamp - last.stamp > config.patience:
            return None
        centre_now = tracker.update(robot.stamp, seen and seen.detection.centre)
        if centre_now is not None:
            column = centre_now[0]
        if robot.stamp - planned >= config.replan_every:
            path, planned = route(robot, last.position, near=config.standoff), robot.stamp
        target = ImageTarget(column, last.depth)
        yield controller.step(
            robot.pose, robot.twist, path, robot.grid.clearance(), robot.grid.frame, target=target, bumper=robot.bumper
        )
    yield STOP
    return last
