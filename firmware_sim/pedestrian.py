"""A person who walks through the house without looking: where they are at any time, and how sensors see them."""

from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel

# Colours from the floor up: the height [m] that each reaches to.
CLOTHES = ((0.08, (52, 46, 44)), (0.85, (58, 70, 104)), (1.48, (146, 60, 54)), (np.inf, (204, 166, 140)))
SHADED = 0.6  # brightness of what is seen edge-on


@dataclass(frozen=True)
class Figure:
    """A person at one moment: an upright cylinder. Wider than legs are at the lidar's height, and it swings no arms."""

    x: float  # m
    y: float  # m
    radius: float  # m
    height: float  # m

    def distances(self, x: float, y: float, directions: np.ndarray) -> np.ndarray:
        """How many times ``directions (N, 2)`` from (x, y) it is to the cylinder: ``(N,)``, inf where it is missed."""
        centre = np.array([self.x - x, self.y - y])
        along, square = directions @ centre, (directions * directions).sum(1)
        inside = along * along - square * (centre @ centre - self.radius**2)
        distance = (along - np.sqrt(np.maximum(inside, 0.0))) / square
        return np.where((inside >= 0) & (distance > 0), distance, np.inf)

    def draw(self, camera: np.ndarray, model: CameraModel, rgb, depth, instances) -> None:
        """Put the person into a picture ``(H, W, ...)`` where nearer than what is there; ``camera`` (3,) is its pose.

        In ``instances`` a person is no object: -1.
        """
        x, y, heading = camera
        left = (model.centre[0] - np.arange(model.width)) / model.focal
        cos, sin = np.cos(heading), np.sin(heading)
        rays = np.stack([cos - sin * left, sin + cos * left], axis=1)  # 1 m along the optical axis
        surface = self.distances(x, y, rays)
        columns = np.flatnonzero(np.isfinite(surface))
        if not len(columns):
            return
        surface, rays = surface[columns], rays[columns]
        up = (model.centre[1] - np.arange(model.height))[:, None] / model.focal
        height = model.mount_height + up * surface
        seen = (height >= 0) & (height <= self.height) & (surface < depth[:, columns])
        normal = ((x, y) + surface[:, None] * rays - (self.x, self.y)) / self.radius
        facing = -(normal * rays).sum(1) / np.linalg.norm(rays, axis=1)
        tops, colours = zip(*CLOTHES)
        look = np.array(colours)[np.searchsorted(tops, height)] * (SHADED + (1 - SHADED) * facing)[:, None]
        row, column = np.nonzero(seen)
        at = row, columns[column]
        rgb[at], depth[at], instances[at] = look[row, column], surface[column], -1


@dataclass(frozen=True, eq=False)
class Pedestrian:
    """Walks a polyline at constant speed, blind to the robot and to walls; stands at its ends before and after."""

    waypoints: np.ndarray  # (K, 2) m, in the house frame
    speed: float  # m/s; people walk indoors at 0.5 to 1.2
    departure: float = 0.0  # s on the world's clock
    radius: float = 0.25  # m, half the width of a person's shoulders
    height: float = 1.7  # m

    def __post_init__(self):
        if len(self.waypoints) < 2 or not self.speed > 0:
            raise ValueError("A pedestrian needs two waypoints or more, and a positive speed.")

    def position(self, time) -> np.ndarray:
        """Where the person is at ``time`` [s], of any shape ``S``: ``S + (2,)`` m."""
        waypoints = np.asarray(self.waypoints, float)
        reached = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(waypoints, axis=0).T))])
        walked = self.speed * (np.asarray(time) - self.departure)
        return np.stack([np.interp(walked, reached, waypoints[:, axis]) for axis in (0, 1)], axis=-1)

    def figure(self, time: float) -> Figure:
        """How the person stands there at ``time`` [s]."""
        x, y = self.position(time).tolist()
        return Figure(x, y, self.radius, self.height)
