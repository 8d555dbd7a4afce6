"""The navigation function of MPEPC's progress cost: distance to go along the Theta* path ([V] Sec. III-D)."""

from dataclasses import dataclass

import numpy as np

from edge.planning.control_law import RollOuts
from edge.pose import wrap


@dataclass(frozen=True)
class ProgressConfig:
    """What lengthens the way besides its length."""

    off_path: float = 0.5  # m of progress per m beside the path
    heading: float = 0.5  # how much a rad of final heading error lengthens the last part of the path
    heading_range: float = 0.3  # m before the end, where the final heading counts most


class PathProgress:
    """Distance to go along a path, the navigation function of the progress cost."""

    def __init__(self, path: np.ndarray, xy, reach: float):
        """Keeps the part of ``path (K, 2)`` [m] that a robot at ``xy`` comes near to within ``reach`` [m] of travel."""
        path = np.asarray(path, float)
        length = np.hypot(*np.diff(path, axis=0).T)
        keep = np.concatenate([length > 1e-9, [True]])
        path, length = path[keep], length[keep[:-1]]
        self.end = path[-1]
        to_go = np.concatenate([np.cumsum(length[::-1])[::-1], [0.0]])
        self._path, self._to_go = path, to_go
        if len(path) == 1:
            self._a, self._unit, self._length, self._left = path, np.zeros((1, 2)), np.zeros(1), np.zeros(1)
            self.travelled = 0.0
            return
        self._a, self._unit, self._length = path[:-1], np.diff(path, axis=0) / length[:, None], length
        self._left = to_go[:-1]
        remaining, _ = self.project(*np.asarray(xy, float)[:2])
        self.travelled = to_go[0] - float(remaining)
        start = to_go[0] - self._left  # arc length where each segment begins
        near = (start <= self.travelled + reach) & (start + length >= self.travelled - 0.5)
        self._a, self._unit, self._length, self._left = (
            part[near] for part in (self._a, self._unit, self._length, self._left)
        )

    def project(self, x, y):
        """Distance to go [m] of the path's nearest point, and the distance from it, each of the shape of x and y."""
        dx, dy = np.asarray(x)[..., None] - self._a[:, 0], np.asarray(y)[..., None] - self._a[:, 1]
        along = np.clip(dx * self._unit[:, 0] + dy * self._unit[:, 1], 0.0, self._length)
        aside = (dx - along * self._unit[:, 0]) ** 2 + (dy - along * self._unit[:, 1]) ** 2
        best = aside.argmin(axis=-1)[..., None]
        along, aside = np.take_along_axis(along, best, -1)[..., 0], np.take_along_axis(aside, best, -1)[..., 0]
        return self._left[best[..., 0]] - along, np.sqrt(aside)

    def ahead(self, distances) -> np.ndarray:
        """Poses ``(N, 3)`` on the path, along it, ``distances (N,)`` [m] further than the robot, at most its end."""
        s = np.minimum(self.travelled + np.asarray(distances, float), self._to_go[0])
        arc = self._to_go[0] - self._to_go
        x, y = np.interp(s, arc, self._path[:, 0]), np.interp(s, arc, self._path[:, 1])
        if len(self._path) == 1:
            return np.stack([x, y, np.zeros_like(x)], axis=-1)
        segment = np.clip(np.searchsorted(arc, s, side="right") - 1, 0, len(self._path) - 2)
        direction = np.diff(self._path, axis=0)[segment]
        return np.stack([x, y, np.arctan2(direction[:, 1], direction[:, 0])], axis=-1)


def distance_to_go(
    out: RollOuts, progress: PathProgress, goal_heading: float | None, config: ProgressConfig
) -> np.ndarray:
    """Navigation function ``(N, S + 1)`` [m]: along the path, plus deviations from it and from the final heading."""
    to_go, beside = progress.project(out.x, out.y)
    value = to_go + config.off_path * beside
    if goal_heading is not None:
        # Nothing far away, and nothing at the end: there the robot turns on the spot, and a penalty that stayed would
        # hold it back just short of an end that it can only reach with another heading.
        near = to_go * np.exp(-to_go / config.heading_range)
        value = value + config.heading * near * np.abs(wrap(out.heading - goal_heading))
    return value
