"""What one depth image says about the ground plan: obstacles of the robot's height, and ground seen to be clear."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from edge.camera import CameraModel


@dataclass(frozen=True)
class DepthViewConfig:
    """How a depth image is read."""

    min_height: float = 0.10  # m; lower things are driven over or are floor noise ([U] Sec. IV)
    max_height: float = 1.00  # m, the robot's height ([U] Sec. IV)
    max_range: float = 4.5  # m; beyond, the noise of depth cameras exceeds a cell
    drop: float = 0.15  # m below the floor: less than a stair, more than a carpet's edge or a base that nods by 2 deg
    drop_range: float = 2.5  # m, within which that can be told
    column_step: int = 2  # px; 0.6 deg at the centre, 4 cm at 4 m
    row_step: int = 3  # px; 6 cm at 4 m


@dataclass(frozen=True)
class _Rays:
    """The sampled pixels of one camera: fixed, so computed once."""

    rows: slice
    columns: slice
    rise: np.ndarray  # (R, 1) m of height gained for each metre of depth
    left: np.ndarray  # (C,) m to the left for each metre of depth
    low: np.ndarray  # (R, 1) depth [m] where a ray is down at min_height; inf for rays that never are
    floor: np.ndarray  # (R, 1) depth [m] where it meets the floor; inf beyond drop_range


@lru_cache(maxsize=4)
def _rays(camera: CameraModel, config: DepthViewConfig) -> _Rays:
    u0, v0 = camera.centre
    above = (config.max_height - camera.mount_height) / camera.min_depth  # rays rising faster never show an obstacle
    rows = slice(max(0, int(v0 - camera.focal * max(above, 0.0))), camera.height, config.row_step)
    columns = slice(0, camera.width, config.column_step)
    rise = ((v0 - np.arange(camera.height)[rows]) / camera.focal).astype(np.float32)
    left = ((u0 - np.arange(camera.width)[columns]) / camera.focal).astype(np.float32)
    drop = camera.mount_height - config.min_height
    low = np.where(rise < 0, drop / np.maximum(-rise, 1e-6), np.inf).astype(np.float32)
    floor = np.where(rise < 0, camera.mount_height / np.maximum(-rise, 1e-6), np.inf).astype(np.float32)
    floor[floor > config.drop_range] = np.inf
    return _Rays(rows, columns, rise[:, None], left, low[:, None], floor[:, None])


@dataclass(frozen=True)
class DepthView:
    """Ground plan of one depth image in base_link."""

    obstacles: np.ndarray  # (N, 2) m, points of obstacles, and of floor that is not there: stairs down
    clear_from: np.ndarray  # (M, 2) m, start of a stretch of clear ground ...
    clear_to: np.ndarray  # (M, 2) m, ... and its end, one for each image column that shows any

    @classmethod
    def read(cls, depth: np.ndarray, camera: CameraModel, config: DepthViewConfig, margin: float) -> "DepthView":
        """Reads ``depth`` (H, W) float32 m, 0 or NaN = no return. ``margin`` [m] is left before an obstacle.

        Ground is clear in a column from where the camera first sees down to ``min_height`` (nearer, a stool would be
        below the image) up to the first obstacle, or to the first row without a return: something nearer than
        the camera's minimum depth, or black, hides what is behind. Single missing pixels do not count.
        Raises ValueError when the image is not of the camera's size.
        """
        if depth.shape != (camera.height, camera.width):
            raise ValueError(
                f"The depth image is {depth.shape[1]}x{depth.shape[0]} but the camera model says "
                f"{camera.width}x{camera.height}; set the camera model from camera_info."
            )
        rays = _rays(camera, config)
        reach = min(camera.max_depth, config.max_range)
        d = np.ascontiguousarray(depth[rays.rows, rays.columns], np.float32)
        d = np.where((d >= camera.min_depth) & np.isfinite(d), d, np.float32(0))
        height = camera.mount_height + d * rays.rise
        obstacle = (d > 0) & (d <= reach) & (height > config.min_height) & (height < config.max_height)
        missing = (d > 0) & (height < -config.drop) & np.isfinite(rays.floor)

        passes = cv2.dilate(d, np.ones((3, 1), np.uint8)) >= rays.low
        hidden = np.where(passes, np.inf, rays.low).min(axis=0)
        d = np.where(missing, rays.floor, d)
        obstacle |= missing
        first = np.where(obstacle, d, np.inf).min(axis=0) - margin
        end = np.minimum(np.minimum(first, hidden), reach)
        start = rays.low[-1, 0]
        clear = end > start

        row, column = np.nonzero(obstacle)
        hits = _ground(d[row, column], rays.left[column], camera)
        left = rays.left[clear]
        return cls(hits, _ground(np.full(len(left), start), left, camera), _ground(end[clear], left, camera))


def _ground(depth: np.ndarray, left: np.ndarray, camera: CameraModel) -> np.ndarray:
    """Points ``(N, 2)`` in base_link [m] at ``depth`` (N,) [m], ``left`` (N,) metres to the left for each metre."""
    return np.stack([camera.ahead + depth, camera.left + depth * left], axis=-1)
