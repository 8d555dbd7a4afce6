"""The ground that one depth image looks over, as a polygon: from the camera to the farthest return of each column."""

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.sight_line import mapped_depth
from edge.pose import transform

_SHIFT = 4  # fractional bits of cv2's polygon corners: 1/16 of a cell


def view_fan(pose, depth, camera: CameraModel, grid: OccupancyGrid, columns: int, reach: float) -> np.ndarray:
    """Corners ``(columns + 1, 2)`` [m] in the map of what ``depth (H, W)`` [m], taken from ``pose (3,)``, looks over.

    Nothing beyond the slant range ``reach`` [m] counts. Where a column has no return at all, the map tells how far one
    can see.
    """
    u = np.linspace(0, depth.shape[1] - 1, columns)
    ends = farthest(depth, columns)
    blank = ends == 0
    ends[blank] = mapped_depth(grid, camera, pose, u[blank])
    tan = (camera.centre[0] - u) / camera.focal
    # Depth is measured along the axis; cap the slant range, not the depth.
    along = np.minimum(ends, reach / np.hypot(1, tan))
    corners = np.stack([camera.ahead + along, camera.left + along * tan], axis=-1)
    return transform(pose, np.vstack([[[camera.ahead, camera.left]], corners]))


def farthest(depth: np.ndarray, columns: int) -> np.ndarray:
    """Farthest return [m] in each of ``columns`` evenly spread over ``depth (H, W)``; 0 where nothing came back.

    Low furniture does not hide what rises behind it.
    """
    picked = depth[::4, np.linspace(0, depth.shape[1] - 1, columns).round().astype(np.intp)]
    return np.nan_to_num(picked, nan=0.0).max(axis=0)


def fill(mask: np.ndarray, frame: GridFrame, fan: np.ndarray) -> None:
    """Set the cells of ``mask`` (R, C) uint8 that lie in the polygon ``fan`` (N, 2) [m] to 1."""
    cells = (fan - frame.origin) / frame.resolution - 0.5
    cv2.fillPoly(mask, [np.round(cells * (1 << _SHIFT)).astype(np.int32)], 1, shift=_SHIFT)
