"""Where to look next when the object is not where the memory says: [V] Sec. III-F, Eqs. 7–12."""

from dataclasses import dataclass
from math import hypot
from random import Random

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.planning.viewpoint import visible_cells


@dataclass(frozen=True)
class LocalSearchConfig:
    """The probability map, the choice of the next view, and when to give up."""

    size: float = 10.0  # m, side of the map: all that the viewpoint could see; [V] has 6
    elsewhere: float = 0.97  # p_nl of cells that may hold the object, before any viewpoint; [V] has 0.9
    missed: float = 0.2  # share of p_l left in view after a look that did not show the object, [V]
    replans: int = 12  # views before giving up, [V] gives none
    samples: int = 48  # poses judged each time, about 1 ms each
    drawn: int = 480  # poses drawn, of which the first so many are judged that something probable is in sight of
    distance_weight: float = 0.15  # w_d, per m of way over half of the map's side
    quality_weight: float = 1.0  # w_q, per share of the remaining probability that is in view
    obstacle_weight: float = 0.1  # w_obs, per shortfall of comfort
    comfort: float = 0.6  # m of clearance; more is no better
    worthwhile: float = 0.005  # share of the first probability that a view must show; less and the search ends


@dataclass(frozen=True, slots=True)
class Replan:
    """A view that was chosen, and the probability map that it was chosen by."""

    frame: GridFrame
    probability: np.ndarray  # (R, C) float32, p_l
    pose: np.ndarray  # (3,)


class LocalSearch:
    """Object localization probability around a place, and the views that search through it.

    ``probability (R, C)`` is p_l = 1 − p_nl on the cells of ``frame``, a square of ``config.size`` around the centre,
    aligned with the grid it was made from. It keeps its own copies of the map: the viewpoints looked at the home as it
    was remembered, the robot looks at it as it is now, with whatever has come to stand between.
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

        ``occupied`` and ``free (R, C)`` bool on ``frame`` are the home as they saw it. Each multiplies p_nl in its
        field of view by 1 − p* (Eq. 7). In [V] occupied cells keep p_nl = 1; but objects stand *on* what is occupied,
        so here the surface of obstacles, the occupied cells beside free ones, is a place to look at like any other.
        """
        self.camera, self.config, self.replans = camera, config, 0
        cells = round(config.size / frame.resolution)
        corner = frame.to_world(*(i - cells // 2 for i in frame.to_cell(np.asarray(centre, float)[:2])))
        origin = corner - frame.resolution / 2
        self.frame = GridFrame((float(origin[0]), float(origin[1])), frame.resolution, (cells, cells))
        self.notice(occupied, frame)
        beside_free = cv2.dilate(self._window(free, frame).view(np.uint8), np.ones((3, 3), np.uint8))
        inside = self._occupied & ~beside_free.astype(bool)
        absent = np.where(inside, 1.0, config.elsewhere)
        viewpoints = np.asarray(viewpoints, float).reshape(-1, 3)
        for pose, p in zip(viewpoints, np.broadcast_to(np.asarray(p_star, float), len(viewpoints))):
            view = np.zeros(absent.shape, bool)
            view.ravel()[self._in_view(pose)] = True
            absent[view & ~inside] *= 1.0 - min(max(p, 0.0), 1.0)
        self.probability = (1.0 - absent).astype(np.float32)
        self._first = float(self.probability.sum())

    def expect(self, place, radius: float) -> None:
        """It is seen to be within ``radius`` [m] of ``place (2,)`` [m], and nowhere else."""
        self.probability[~self.frame.within(radius, place)] = 0.0
        self._first = float(self.probability.sum())

    def notice(self, occupied: np.ndarray, frame: GridFrame) -> None:
        """What stands in the way from now on: ``occupied (R, C)`` bool on ``frame``, the grid's at this moment."""
        self._occupied = self._window(occupied, frame)

    def next_pose(
        self,
        robot_pose,
        reachable: np.ndarray,
        clearance: np.ndarray,
        frame: GridFrame,
        rng: Random,
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
        best, best_cost = None, np.inf
        for pose, gap in self._samples(frame.to_world(rows, cols), clearance[rows, cols], rng):
            seen = float(self.probability.ravel()[self._in_view(pose)].sum())
            cost = (
                self.config.distance_weight * hypot(*(pose[:2] - robot_pose[:2])) / (0.5 * self.config.size)
                - self.config.quality_weight * seen / total
                + self.config.obstacle_weight * max(0.0, 1.0 - gap / self.config.comfort)
            )
            if cost < best_cost and seen >= self.config.worthwhile * self._first:
                best, best_cost = pose, cost
        return best

    def observed(self, pose) -> None:
        """A look from ``pose (3,)`` did not show the object."""
        self.probability.ravel()[self._in_view(pose)] *= self.config.missed

    def _samples(self, places: np.ndarray, gaps: np.ndarray, rng: Random):
        """Pairs of a pose at one of ``places (N, 2)``, facing a cell in sight drawn by its probability, and the gap."""
        # Not numpy's generator: loading it takes 2 MB, and it would be the only one of its kind on the robot.
        chosen = np.array([rng.randrange(len(places)) for _ in range(self.config.drawn)])
        below = np.cumsum(self.probability.ravel(), dtype=float)
        towards = np.searchsorted(below, [below[-1] * rng.random() for _ in chosen], side="right")
        looked_at = self.frame.to_world(*np.unravel_index(towards, self.probability.shape))
        kept = np.flatnonzero(self._in_sight(places[chosen], looked_at))[: self.config.samples]
        chosen = chosen[kept]
        offset = looked_at[kept] - places[chosen]
        headings = np.arctan2(offset[:, 1], offset[:, 0])
        return zip(np.column_stack([places[chosen], headings]), gaps[chosen].tolist())

    def _in_sight(self, places: np.ndarray, looked_at: np.ndarray) -> np.ndarray:
        """Which of ``places (N, 2)`` have nothing between them and ``looked_at (N, 2)``, near enough to be seen."""
        away = np.hypot(*(looked_at - places).T)
        # Up to 3 cells before the end, which may itself be the surface of something.
        stop = np.maximum(1 - 3 * self.frame.resolution / np.maximum(away, 1e-9), 0)
        share = np.linspace(0, 1, 2 * len(self._occupied))[:, None] * stop
        lines = places + share[..., None] * (looked_at - places)
        row, col = self.frame.to_cell(lines)
        blocked = self._occupied[row, col].any(axis=0)
        return ~blocked & (away <= self.camera.max_depth) & (away >= self.camera.min_depth)

    def _in_view(self, pose) -> np.ndarray:
        return visible_cells(self._occupied, self.frame, pose, self.camera)

    def _window(self, grid: np.ndarray, frame: GridFrame) -> np.ndarray:
        """The part of ``grid (R, C)`` on ``frame`` that lies in the square, False outside."""
        out = np.zeros(self.frame.shape, bool)
        cells = len(out)
        row, col = (int(i) for i in frame.to_cell(self.frame.to_world(0, 0)))
        top, left = max(row, 0), max(col, 0)
        part = grid[top : max(row + cells, 0), left : max(col + cells, 0)]
        out[top - row : top - row + part.shape[0], left - col : left - col + part.shape[1]] = part
        return out
