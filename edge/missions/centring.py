"""Drive up to an object in view and bring it to the middle of the picture ([V] Sec. III-D, Eqs. 4-6)."""

from dataclasses import dataclass

import numpy as np

from edge.missions.mission import Story
from edge.missions.motion import controller_for, route, steer
from edge.missions.sighting import Sighting, sight
from edge.observation import STOP
from edge.perception.close_look import window_at
from edge.perception.detection import Detection, Detector
from edge.perception.encoder import View
from edge.perception.prompts import Target
from edge.perception.tracking import BoxTracker
from edge.planning.centring import ImageTarget, seen_after
from edge.pose import between
from edge.robot import Robot


@dataclass(frozen=True)
class CentringConfig:
    """When the approach ends."""

    patience: float = 2.0  # s that it is looked for in vain, after which it is lost
    wide: float = 0.35  # of the picture's width; what was wider is looked for in the whole picture, else in a window
    replan_every: float = 1.0  # s
    standoff: float = 1.5  # m from the object's place to the nearest floor that the way there may end at
    time_limit: float = 30.0  # s; a noisy box may never settle within the tolerance, and near enough is good


CONFIG = CentringConfig()


def centre(robot: Robot, detector: Detector, sought: Target, first: Sighting, config: CentringConfig = CONFIG) -> Story:
    """Approach until near and centred; the last ``Sighting``, or None when the object was lost on the way."""
    controller = controller_for(robot)
    tracker = BoxTracker()
    u, row = tracker.update(first.stamp, first.detection.centre)
    target, pose = ImageTarget(u, first.depth), first.pose  # as seen from there
    last, started, planned = first, robot.stamp, -np.inf
    while not controller.arrived and robot.stamp - started < config.time_limit:
        here = robot.pose if robot.frame is None else robot.in_map(robot.frame.odom)
        expected = seen_after(target, between(pose, here), robot.camera)
        tracker.shift(expected.u - target.u)
        target, pose = expected, here
        seen = None
        if robot.frame is not None:
            seen = sight(robot, detector, sought, [_view(robot, (target.u, row), last.detection, config)])
        if seen is not None:
            last = seen
        elif robot.stamp - max(last.stamp, started) > config.patience:
            return None
        u, row = tracker.update(robot.stamp, seen and seen.detection.centre) or (target.u, row)
        target = ImageTarget(u, target.depth if seen is None else seen.depth)
        if robot.stamp - planned >= config.replan_every:
            path, planned = route(robot, last.position, near=config.standoff), robot.stamp
        now = seen_after(target, between(pose, robot.pose), robot.camera)
        yield steer(robot, controller, path, target=now)
    yield STOP
    return last


def _view(robot: Robot, middle: tuple[float, float], last: Detection, config: CentringConfig) -> View:
    """The picture around the object: one pass of the image tower."""
    height, width = robot.frame.depth.shape
    wide = last.box[2] - last.box[0] > config.wide * width
    window = None if wide else window_at(middle, width, height)
    return robot.encoder.encode_image(robot.frame.rgb, robot.camera.hfov, window)
