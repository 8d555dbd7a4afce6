"""Where to look next when the object is not where the memory says: [V] Sec. III-F, Eqs. 7–12."""

from dataclasses import dataclass
from math import hypot

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.planning.viewpoint import visible_cells


@dataclass(frozen=True)
class LocalSearchConfig:
    """The probability map, the choice of the next view, and when to give up."""

    size: float = 6.0  # m, side of the map, [V]
    elsewhere: float = 0.9  # p_nl of cells that may hold the object, before any viewpoint, [V]
    missed: float = 0.2  # share of p_l left in view after a look that did not show the object, [V]
    replans: int = 8  # views before giving up, [V] gives none
    samples: int = 48  # poses judged each time, about 1 ms each
    distance_weight: float = 0.25  # w_d, per m of way over half of the map's side
    quality_weight: float = 1.0  # w_q, per share of the remaining probability that is in view
    obstacle_weight: float = 0.1  # w_obs, per shortfall of comfort
    comfort: float = 0.6  # m of clearance; more is no better
    worthwhile: float = 0.02  # share of the first probability that a view must show; less and the search ends


@dataclass(frozen=True, slots=True)
class Replan:
    """A view that was chosen, and the probability map that it was chosen by."""

    frame: GridFrame
    probability: np.ndarray  # (R, C) float32, p_l
    pose: np.ndarray  # (3,)


class LocalSearch:
    """Object localization probability around a place, and the views that search through it.

    ``probability (R, C)`` is p_l = 1 − p_nl on the cells of ``frame``, a square of ``config.size`` around the centre,
    aligned with the grid it was made from. It keeps its own copy of the map, so that the grid may grow meanwhile.
    """

    def __init__(
        self,
        occupied: np.ndarray,
        free: np.ndarray,
        frame: GridFrame,
        centre,
        viewpoints: np.ndarray,
        p_star,
        camera: CameraModel,
        config: LocalSearchConfig = LocalSearchConfig(),
    ):
        """Seeds the map with the viewpoints ``(N, 3)`` of a cluster and their scores ``p_star``, one or ``(N,)``.

        Each multiplies p_nl in its field of view by 1 − p* (Eq. 7). In [V] occupied cells keep p_nl = 1; but objects
        stand *on* what is occupied, so here the surface of obstacles, the occupied cells beside free ones, counts as a
        place to look at like any other.
        """
        self.camera, self.config, self.replans = camera, config, 0
        cells = round(config.size / frame.resolution)
        row, col = (int(i) - cells // 2 for i in frame.to_cell(np.asarray(centre, float)[:2]))
        corner = (frame.origin[0] + col * frame.resolution, frame.origin[1] + row * frame.resolution)
        self.frame = GridFrame(corner, frame.resolution, (cells, cells))
        self._occupied = _window(occupied, row, col, cells)
        beside_free = cv2.dilate(_window(free, row, col, cells).astype(np.uint8), np.ones((3, 3), np.uint8))
        inside = self._occupied & ~beside_free.astype(bool)
        absent = np.where(inside, 1.0, config.elsewhere)
        viewpoints = np.asarray(viewpoints, float).reshape(-1, 3)
        for pose, p in zip(viewpoints, np.broadcast_to(np.asarray(p_star, float), len(viewpoints))):
            view = np.zeros(absent.shape, bool)
            view.ravel()[self._in_view(pose)] = True
            absent[view & ~inside] *= 1.0 - min(max(p, 0.0), 1.0)
        self.probability = (1.0 - absent).astype(np.float32)
        self._first = float(self.probability.sum())

    def next_pose(
        self,
        robot_pose,
        reachable: np.ndarray,
        clearance: np.ndarray,
        frame: GridFrame,
        rng: np.random.Generator,
    ) -> np.ndarray | None:
        """The pose ``(3,)`` to look from next, or None: limit of replans, nowhere to go, or nothing worth seeing.

        ``reachable (R, C)`` bool and ``clearance (R, C)`` [m] are on ``frame``, the grid's at this moment. Minimises
        J = w_d·J_distance + w_q·J_quality + w_obs·J_obstacle (Eq. 8) over sampled poses. J_quality in Eq. 10 as printed
        sums 1 − p_l, which rewards seeing few cells; here it is −Σ p_l in view, as a share of Σ p_l.
        """
        total = float(self.probability.sum())
        if self.replans >= self.config.replans or total <= 0.0:
            return None
        rows, cols = np.nonzero(reachable)
        near = self.frame.contains(*self.frame.to_cell(frame.to_world(rows, cols)))
        rows, cols = rows[near], cols[near]
        if len(rows) == 0:
            return None
        self.replans += 1
        best, best_cost, best_seen = None, np.inf, 0.0
        for pose, gap in self._samples(frame.to_world(rows, cols), clearance[rows, cols], rng):
            seen = float(self.probability.ravel()[self._in_view(pose)].sum())
            cost = (
                self.config.distance_weight * hypot(*(pose[:2] - robot_pose[:2])) / (0.5 * self.config.size)
                - self.config.quality_weight * seen / total
                + self.config.obstacle_weight * max(0.0, 1.0 - gap / self.config.comfort)
            )
            if cost < best_cost:
                best, best_cost, best_seen = pose, cost, seen
        return best if best_seen >= self.config.worthwhile * self._first else None

    def observed(self, pose) -> None:
        """A look from ``pose (3,)`` did not show the object."""
        self.probability.ravel()[self._in_view(pose)] *= self.config.missed

    def _samples(self, places: np.ndarray, gaps: np.ndarray, rng: np.random.Generator):
        """Pairs of a pose at one of ``places (N, 2)``, facing a cell drawn by its probability, and the clearance."""
        chosen = rng.choice(len(places), size=self.config.samples, replace=len(places) < self.config.samples)
        weight = self.probability.ravel().astype(float)
        towards = rng.choice(weight.size, size=len(chosen), p=weight / weight.sum())
        looked_at = self.frame.to_world(*np.unravel_index(towards, self.probability.shape))
        offset = looked_at - places[chosen]
        headings = np.arctan2(offset[:, 1], offset[:, 0])
        return zip(np.column_stack([places[chosen], headings]), gaps[chosen].tolist())

    def _in_view(self, pose) -> np.ndarray:
        return visible_cells(self._occupied, self.frame, pose, self.camera)


def _window(grid: np.ndarray, row: int, col: int, cells: int) -> np.ndarray:
    """Square of ``grid`` from (row, col), False outside."""
    out = np.zeros((cells, cells), bool)
    top, left = max(row, 0), max(col, 0)
    part = grid[top : max(row + cells, 0), left : max(col + cells, 0)]
    out[top - row : top - row + part.shape[0], left - col : left - col + part.shape[1]] = part
    return out
