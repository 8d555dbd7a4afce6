"""How far the map lets the camera see: for pixels without a depth return, which may be too near as well as too far."""

import numpy as np

from edge.camera import CameraModel
from edge.mapping.occupancy import OccupancyGrid
from edge.pose import transform


def mapped_depth(grid: OccupancyGrid, camera: CameraModel, pose, u) -> np.ndarray:
    """Depth ``(N,)`` [m] of the first mapped obstacle in pixel columns ``u (N,)`` of a picture from ``pose (3,)``.

    The camera's maximum where there is none.
    """
    frame = grid.frame
    depths = np.arange(frame.resolution, camera.max_depth, frame.resolution / 2)
    points = camera.unproject(np.asarray(u, float)[:, None], camera.centre[1], depths)[..., :2]
    row, col = frame.to_cell(transform(pose, points.reshape(-1, 2)).reshape(points.shape))
    inside = frame.contains(row, col)
    met = np.zeros(row.shape, bool)
    met[inside] = grid.occupied[row[inside], col[inside]]
    return np.where(met.any(axis=1), depths[met.argmax(axis=1)], camera.max_depth)
