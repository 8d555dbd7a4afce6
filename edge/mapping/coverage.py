"""Where the camera, unlike the lidar, has looked from close enough to remember what stands there."""

from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.view_fan import fill, view_fan
from edge.mapping.warp import warped


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
