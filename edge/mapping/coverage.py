"""Where the camera, unlike the lidar, has looked from close enough to remember what stands there."""

from dataclasses import dataclass

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.sight_line import mapped_depth
from edge.mapping.warp import warped
from edge.pose import transform


@dataclass(frozen=True)
class CoverageConfig:
    """How close a look counts."""

    range: float = 3.0  # m; a 0.4 m object then still spans 26 of 320 columns
    columns: int = 40  # depth columns per frame; 2 degrees each


class CameraCoverage:
    """Cells that a camera view has covered, as a mask that follows the occupancy grid as it grows."""

    _SHIFT = 4  # fractional bits of cv2's polygon corners: 1/16 of a cell

    def __init__(self, config: CoverageConfig | None = None):
        self.config = config or CoverageConfig()
        self.frame: GridFrame | None = None
        self.viewed = np.zeros((0, 0), np.uint8)

    def integrate(self, pose, depth, camera: CameraModel, grid: OccupancyGrid) -> None:
        """Mark what one depth image ``(H, W)`` [m], taken from base ``pose (3,)``, has looked at."""
        self.follow(grid.frame)
        u = np.linspace(0, depth.shape[1] - 1, self.config.columns)
        reach = farthest(depth, self.config.columns)
        blank = reach == 0
        reach[blank] = mapped_depth(grid, camera, pose, u[blank])
        tan = (camera.centre[0] - u) / camera.focal
        # Reach is measured along the axis; cap the slant range, not the depth.
        along = np.minimum(reach, self.config.range / np.hypot(1, tan))
        corners = np.stack([camera.ahead + along, camera.left + along * tan], axis=-1)
        fan = transform(pose, np.vstack([[[camera.ahead, camera.left]], corners]))
        cells = (fan - self.frame.origin) / self.frame.resolution - 0.5
        cv2.fillPoly(self.viewed, [np.round(cells * (1 << self._SHIFT)).astype(np.int32)], 1, shift=self._SHIFT)

    def forget(self) -> None:
        """Nothing has been looked at, as at the beginning of a tour."""
        self.viewed[:] = 0

    def move(self, frame: GridFrame, column, row) -> None:
        """Move along with a grid that now lies in ``frame`` and was warped from ``column`` and ``row`` (H, W)."""
        self.follow(frame)
        self.viewed = warped(self.viewed, column, row)

    def follow(self, frame: GridFrame) -> None:
        """Take on the shape of a grid that has grown; what was viewed stays where it is in the map."""
        if frame == self.frame:
            return
        viewed = np.zeros(frame.shape, np.uint8)
        if self.frame is not None:
            row, col = frame.to_cell(self.frame.to_world(0, 0))
            rows, cols = self.viewed.shape
            viewed[row : row + rows, col : col + cols] = self.viewed
        self.frame, self.viewed = frame, viewed


def farthest(depth: np.ndarray, columns: int) -> np.ndarray:
    """Farthest return [m] in each of ``columns`` evenly spread over ``depth (H, W)``; 0 where nothing came back.

    Low furniture does not hide what rises behind it.
    """
    picked = depth[::4, np.linspace(0, depth.shape[1] - 1, columns).round().astype(np.intp)]
    return np.nan_to_num(picked, nan=0.0).max(axis=0)
