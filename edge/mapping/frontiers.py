"""Frontiers: where explored ground ends and the unknown begins (Yamauchi 1997; [U] Sec. IV)."""

from dataclasses import dataclass

import cv2
import numpy as np

from edge.mapping.occupancy import OccupancyGrid


@dataclass(frozen=True)
class Frontier:
    """One stretch of the boundary of explored ground."""

    cells: np.ndarray  # (N, 2) m, centres of its cells in order along it
    waypoint: np.ndarray  # (2,) m, its midpoint by arc length


def frontiers(
    grid: OccupancyGrid,
    position: np.ndarray,
    robot_radius: float,
    min_area: float = 1.5,
    explored: np.ndarray | None = None,
) -> list[Frontier]:
    """Frontiers that a robot at ``position`` (2,) or pose (3,) [m] can drive to, longest first.

    A frontier is a run of cells that the robot of ``robot_radius`` [m] can reach over known ground and that touch an
    unknown region of at least ``min_area`` [m²]; smaller ones are pockets not worth a trip ([U] Sec. IV). Its waypoint
    is the midpoint by arc length, as in VLFM. Stretches shorter than the robot is wide are dropped: it cannot pass.
    Cells outside ``explored`` (H, W) bool count as unknown too, e.g. where the camera has not looked yet.
    """
    reach, unknown = reachable(grid, position, robot_radius), grid.unknown
    if explored is not None:
        reach, unknown = reach & explored, unknown | ~explored
    if not reach.any():
        return []
    candidates = reach & _beside_large(unknown, grid.resolution, min_area)
    if not candidates.any():
        return []
    found = []
    contours, _ = cv2.findContours(reach.view(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    for contour in contours:
        col, row = contour[:, 0, 0], contour[:, 0, 1]
        for run in _runs(candidates[row, col]):
            cells = grid.frame.to_world(row[run], col[run])
            steps = np.hypot(*np.diff(cells, axis=0).T)
            length = steps.sum()
            if length + grid.resolution < 2 * robot_radius:
                continue
            middle = np.searchsorted(np.cumsum(steps), length / 2)
            found.append((length, Frontier(cells, cells[middle])))
    found.sort(key=lambda item: -item[0])
    return [frontier for _, frontier in found]


def reachable(grid: OccupancyGrid, position: np.ndarray, robot_radius: float) -> np.ndarray:
    """Traversable cells connected with the one nearest to ``position`` (2,) [m], bool ``(H, W)``.

    The robot's own cell may be blocked in the map (it can stand closer to a wall than planned), so the search starts at
    the nearest traversable cell within three radii; nothing is reachable when there is none.
    """
    traversable = grid.traversable(robot_radius)
    row, col = (int(index) for index in grid.frame.to_cell(np.asarray(position, float)[:2]))
    span = int(3 * robot_radius / grid.resolution)
    top, left = max(row - span, 0), max(col - span, 0)
    rows, cols = np.nonzero(traversable[top : max(row + span + 1, 0), left : max(col + span + 1, 0)])
    if not len(rows):
        return np.zeros(traversable.shape, bool)
    rows, cols = rows + top, cols + left
    nearest = ((rows - row) ** 2 + (cols - col) ** 2).argmin()
    _, labels = cv2.connectedComponents(traversable.view(np.uint8), connectivity=4)
    return labels == labels[rows[nearest], cols[nearest]]


def _beside_large(unknown: np.ndarray, resolution: float, min_area: float) -> np.ndarray:
    """Cells in or beside unknown regions of at least ``min_area`` [m²], bool ``(H, W)``. Beyond the grid is unknown."""
    unknown = np.pad(unknown.view(np.uint8), 1, constant_values=1)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(unknown, connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] * resolution**2 >= min_area
    large[labels[0, 0]] = True
    large[0] = False
    near = cv2.dilate(large.view(np.uint8)[labels], np.ones((3, 3), np.uint8))
    return near[1:-1, 1:-1].astype(bool)


def _runs(mask: np.ndarray) -> list[np.ndarray]:
    """Index runs of True in ``mask`` (N,), a closed loop."""
    if mask.all():
        return [np.arange(len(mask))]
    start = int(np.argmin(mask))  # a False: no run wraps around it
    order = np.roll(np.arange(len(mask)), -start)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask[order], [False]]).astype(np.int8)))
    return [order[a:b] for a, b in edges.reshape(-1, 2)]
