"""How far each point of the floor plan is from the nearest thing that the lidar has mapped."""

from dataclasses import dataclass

import cv2
import numpy as np

from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid


@dataclass(frozen=True)
class LikelihoodField:
    """Distances to the mapped obstacles of the lidar layer (Thrun et al. 2005, Sec. 6.4), cut off at ``reach``."""

    distance: np.ndarray  # (H, W) float32 m at the cell centres, at most reach
    known: np.ndarray  # (H, W) bool: the lidar has measured this cell or one beside it
    frame: GridFrame
    reach: float  # m

    @classmethod
    def around(cls, grid: OccupancyGrid, centre: np.ndarray, radius: float, reach: float = 0.5) -> "LikelihoodField":
        """Field of the square ``radius`` [m] to each side of ``centre`` (2,) or pose (3,), as far as it is mapped."""
        layer, frame = grid.lidar, grid.frame
        row, col = (int(index) for index in frame.to_cell(np.asarray(centre, float)[:2]))
        span = int(radius / grid.resolution) + 1
        top, left = np.clip(row - span, 0, frame.shape[0] - 2), np.clip(col - span, 0, frame.shape[1] - 2)
        layer = layer[top : max(row + span, top + 2), left : max(col + span, left + 2)]
        distance = cv2.distanceTransform((layer <= 0).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
        distance *= grid.resolution
        np.minimum(distance, np.float32(reach), out=distance)
        origin = (frame.origin[0] + left * grid.resolution, frame.origin[1] + top * grid.resolution)
        known = cv2.dilate((layer != 0).view(np.uint8), np.ones((3, 3), np.uint8)).view(bool)
        return cls(distance, known, GridFrame(origin, grid.resolution, layer.shape), reach)

    @property
    def empty(self) -> bool:
        """Whether there is nothing to match with."""
        return not (self.distance == 0).any()

    def sample(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distance (N,) [m], its gradient (N, 2) and whether the map is known there (N,), at ``points`` (N, 2) [m].

        Bilinear between cell centres; outside the field the distance is ``reach``, flat and unknown.
        """
        rows, cols = self.frame.shape
        scaled = (points - self.frame.origin) / self.frame.resolution - 0.5
        whole = np.floor(scaled).astype(np.intp)
        col, row = whole.T
        inside = (row >= 0) & (row < rows - 1) & (col >= 0) & (col < cols - 1)
        index = np.where(inside, row * cols + col, 0)
        flat = self.distance.reshape(-1)
        a, b, c, d = flat[index], flat[index + 1], flat[index + cols], flat[index + cols + 1]
        u, v = (scaled - whole).T
        low, high = a + u * (b - a), c + u * (d - c)
        value = np.where(inside, low + v * (high - low), self.reach)
        slope = np.stack([(b - a) + v * ((d - c) - (b - a)), high - low], axis=-1)
        slope *= (inside / self.frame.resolution)[:, None]
        return value, slope, inside & self.known.reshape(-1)[index]
