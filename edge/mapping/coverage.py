"""Where the camera, unlike the lidar, has looked from close enough to remember what stands there."""

from dataclasses import dataclass
from math import ceil

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.view_fan import fill, view_fan
from edge.mapping.warp import warped

BESIDE = 2  # cells


@dataclass(frozen=True)
class CoverageConfig:
    """How close a look counts."""

    range: float = 3.0  # m; a 0.4 m object then still spans 26 of 320 columns
    columns: int = 40  # depth columns per frame; 2 degrees each


class CameraCoverage:
    """Cells that a camera view has covered, as a mask that follows the occupancy grid as it grows."""

    def __init__(self, config: CoverageConfig | None = None):
        self.config = config or CoverageConfig()
        self.frame: GridFrame | None = None
        self.viewed = np.zeros((0, 0), np.uint8)

    def integrate(self, pose, depth, camera: CameraModel, grid: OccupancyGrid) -> None:
        """Mark what one depth image ``(H, W)`` [m], taken from base ``pose (3,)``, has looked at."""
        self.follow(grid.frame)
        fan = view_fan(pose, depth, camera, grid, self.config.columns, self.config.range)
        fill(self.viewed, self.frame, fan)

    def explored(self, grid: OccupancyGrid, radius: float) -> np.ndarray:
        """Cells that the map knows and the camera has looked at, as at what stands beside them, bool ``(R, C)``.

        Furniture that only the lidar has seen has no cell at its edge that a robot of ``radius`` [m] can reach: the
        floor before it counts as unexplored in its place.
        """
        return self._explored(grid, _reach(grid, radius), np.s_[:, :])

    def has_explored(self, grid: OccupancyGrid, radius: float, place) -> bool:
        """Whether ``place (2,)`` [m], and what is beside it, is among the cells that are ``explored``."""
        row, col = (int(index) for index in grid.frame.to_cell(place))
        reach = _reach(grid, radius)
        top, left = max(row - BESIDE - reach, 0), max(col - BESIDE - reach, 0)
        part = np.s_[top : row + BESIDE + reach + 1, left : col + BESIDE + reach + 1]
        rows = slice(max(row - BESIDE, 0) - top, row + BESIDE + 1 - top)
        cols = slice(max(col - BESIDE, 0) - left, col + BESIDE + 1 - left)
        return bool(self._explored(grid, reach, part)[rows, cols].all())

    def _explored(self, grid: OccupancyGrid, reach: int, part) -> np.ndarray:
        viewed, free = self.viewed[part].view(bool), grid.free[part]
        unseen = grid.occupied[part] & ~viewed
        for _ in range(reach):  # over free floor only, not through walls
            unseen |= cv2.dilate(unseen.view(np.uint8), np.ones((3, 3), np.uint8)).view(bool) & free
        return viewed & ~grid.unknown[part] & ~unseen

    def forget(self) -> None:
        """Nothing has been looked at, as at the beginning of a tour."""
        self.viewed[:] = 0

    def move(self, frame: GridFrame, column, row) -> None:
        """Move along with a grid that now lies in ``frame`` and was warped from ``column`` and ``row`` (H, W)."""
        self.follow(frame)
        self.viewed = warped(self.viewed, column, row)

    def follow(self, frame: GridFrame) -> None:
        """Take on the shape of a grid that has grown; what was viewed stays where it is in the map."""
        if frame != self.frame:
            self.viewed = frame.holding(self.viewed, self.frame, 0)
            self.frame = frame


def _reach(grid: OccupancyGrid, radius: float) -> int:
    """Cells from furniture to the nearest that a robot of ``radius`` [m] can reach, and some."""
    return ceil(radius / grid.resolution) + 2
