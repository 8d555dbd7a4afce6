"""Things that stand out in a depth picture, and pictures of one thing alone.

An encoder names a thing far better when it fills the picture and nothing else is in it. Depth tells where a thing ends
whatever its name: this finds floor, walls and depth steps, and what is left between them.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from edge.camera import CameraModel

STEP = 2  # px; every second pixel is plenty for a thing's outline, and a quarter of the work
HOLES = 0.1  # share of a column's upper half without a return, above which its wall is beyond the sensor


@dataclass(frozen=True)
class ThingsConfig:
    """What counts as floor, as wall, and as the end of a thing. Margins grow with depth as a stereo camera's noise."""

    reach: float = 4.0  # m; beyond, depth noise joins what is apart
    floor: float = 0.03  # m above the floor, and 8 mm more at 1 m
    wall: float = 0.03  # m before the wall, and 12 mm more at 1 m
    noise: float = 0.010  # 1/m, times the squared depth
    tall: float = 2.1  # m; what reaches higher is part of the building
    jump: float = 0.035  # share of the depth by which neighbouring pixels of two things differ
    least: int = 160  # px of the picture, 13 x 13
    margin: float = 0.1  # of its size, left around a thing
    smallest: int = 37  # px, height of the smallest window: enlarged more than six-fold, nothing can be told


CONFIG = ThingsConfig()


@dataclass(frozen=True)
class Thing:
    """One thing: where it is in the picture and before the robot."""

    box: tuple[int, int, int, int]  # left, top, right, bottom px
    mask: np.ndarray  # (H, W) bool, slightly wider than the thing
    depth: float  # m along the optical axis, median
    point: np.ndarray  # (3,) m, the median of its points in base_link


def find_things(depth: np.ndarray, camera: CameraModel, config: ThingsConfig = CONFIG) -> list[Thing]:
    """Things in ``depth`` (H, W) float32 m (0 or NaN = no return) of a level camera, the largest in the picture first.

    In a level camera's picture a vertical wall has one depth in each column, so the farthest return of a column is its
    wall. Half a millisecond for 320x240.
    """
    d = cv2.medianBlur(np.nan_to_num(depth[::STEP, ::STEP]).astype(np.float32), 3)
    v, u = np.arange(d.shape[0])[:, None] * STEP, np.arange(d.shape[1]) * STEP
    height = camera.mount_height + (camera.centre[1] - v) / camera.focal * d
    above = (d > 0) & (height > config.floor + config.noise * d * d)
    wall = _walls(np.where(above, d, 0).max(axis=0), d)
    thing = above & (d < config.reach) & (d < wall - config.wall - config.noise * wall * wall)
    thing &= ~_steps(d, config.jump)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(thing.astype(np.uint8), connectivity=4)
    found = []
    for label in 1 + np.argsort(-stats[1:, cv2.CC_STAT_AREA], kind="stable"):
        if stats[label, cv2.CC_STAT_AREA] * STEP**2 < config.least:
            break
        rows, columns = np.nonzero(labels == label)
        if height[rows, columns].max() > config.tall:
            continue
        point = np.median(camera.unproject(u[columns], v[rows, 0], d[rows, columns]), axis=0)
        mask = cv2.dilate((labels == label).astype(np.uint8), np.ones((3, 3), np.uint8))
        mask = cv2.resize(mask, depth.shape[::-1], interpolation=cv2.INTER_NEAREST)
        left, top, width, tall = cv2.boundingRect(mask)
        median = float(np.median(d[rows, columns]))
        found.append(Thing((left, top, left + width, top + tall), mask.view(bool), median, point))
    return found


def alone(rgb: np.ndarray, thing: Thing, config: ThingsConfig = CONFIG) -> tuple[np.ndarray, tuple]:
    """A copy of RGB ``(H, W, 3)`` in which only the thing is left of its surroundings, and the window around it [px].

    The rest of the window has the mean colour of what was there. The window has the picture's proportions.
    """
    height, width = rgb.shape[:2]
    x0, y0, x1, y1 = thing.box
    room = 1 + 2 * config.margin
    tall = min(max((x1 - x0) * room * height / width, (y1 - y0) * room, config.smallest), height)
    size = np.rint([tall * width / height, tall]).astype(int)
    corner = np.clip(np.rint([(x0 + x1) / 2, (y0 + y1) / 2] - size / 2).astype(int), 0, (width, height) - size)
    left, top, right, bottom = window = tuple(np.concatenate([corner, corner + size]).tolist())
    picture, around = rgb.copy(), ~thing.mask[top:bottom, left:right]
    if around.any():
        part = picture[top:bottom, left:right]
        part[around] = part[around].mean(axis=0).astype(np.uint8)
    return picture, window


def _walls(farthest: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Depth ``(W,)`` [m] of the wall in each column; infinite where it is beyond the sensor."""
    beyond = (d[: len(d) // 2] == 0).mean(axis=0) > HOLES
    # Inverse depth is linear along a wall: its median bridges a column with a hole in it.
    inverse = np.where(beyond, 0, 1 / np.maximum(farthest, 0.3)).astype(np.float32)
    smooth = cv2.medianBlur(inverse[None], 5)[0]
    with np.errstate(divide="ignore"):
        return np.where(smooth > 0, 1 / smooth, 1e3)


def _steps(d: np.ndarray, jump: float) -> np.ndarray:
    """Pixels ``(H, W)`` bool where depth jumps to the one before, in the row or in the column."""
    steps = np.zeros(d.shape, bool)
    for axis in (0, 1):
        near = np.minimum(d, np.roll(d, 1, axis))
        here = np.abs(np.diff(d, axis=axis)) > jump * np.delete(near, 0, axis) + 0.02
        steps[(slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))] |= here
    return steps
