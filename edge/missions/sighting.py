"""An object seen in a picture, and where that puts it in the map."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from edge.mapping.sight_line import mapped_depth
from edge.perception.detection import Detection, Detector
from edge.perception.encoder import View
from edge.perception.prompts import Target
from edge.pose import transform
from edge.robot import Robot

APART = 0.5  # m between two depths in a box that cannot both be the object's


@dataclass(frozen=True, slots=True)
class Sighting:
    """A detection with its place."""

    stamp: float  # s
    pose: np.ndarray  # (3,) of the robot in the map
    detection: Detection
    bearing: float  # rad of the box centre from the optical axis, left positive
    depth: float  # m along the optical axis
    position: np.ndarray  # (2,) m in the map
    behind: np.ndarray | None = None  # (2,) m, where it is if the nearest thing in the box only stands in front of it


def sight(robot: Robot, detector: Detector, target: Target, views: Iterable[View]) -> Sighting | None:
    """The target in ``views`` of the robot's newest picture, where it shows best; None if in none of them."""
    height, width = robot.frame.depth.shape
    detections = [detector.detect(view, target, (width, height)) for view in views]
    detection = max((d for d in detections if d is not None), key=lambda d: d.score, default=None)
    if detection is None:
        return None
    camera = robot.camera
    u, _ = detection.centre
    pose = robot.in_map(robot.frame.odom)
    depths = _depths(robot.frame.depth, detection.box)
    if depths is None:
        depths = np.full(2, mapped_depth(robot.grid, camera, pose, [u])[0])
    near, far = transform(pose, camera.unproject(u, camera.centre[1], depths)[:, :2])
    behind = far if depths[1] - depths[0] > APART else None
    return Sighting(robot.frame.stamp, pose, detection, float(camera.bearing(u)), float(depths[0]), near, behind)


def _depths(depth, box) -> np.ndarray | None:
    """Depth [m] of the near and far quartiles of the middle of a box, ``(2,)``.

    The near one is the object's as a rule, and the rest what shows behind it. None without a return there: the object
    is nearer than the sensor's minimum, beyond its maximum, or black.
    """
    x0, y0, x1, y1 = box
    across, down = (x1 - x0) / 4, (y1 - y0) / 4
    rows = slice(max(int(y0 + down), 0), max(int(np.ceil(y1 - down)), 1))
    cols = slice(max(int(x0 + across), 0), max(int(np.ceil(x1 - across)), 1))
    middle = depth[rows, cols]
    returns = middle[np.isfinite(middle) & (middle > 0)]
    return np.quantile(returns, (0.25, 0.75)) if returns.size else None
