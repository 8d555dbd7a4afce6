"""Where stopping counts, and the shortest way there: the truth behind SR and SPL ([U] Sec. V)."""

import cv2
import numpy as np

from edge.planning.theta_star import plan
from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.placement import ROBOT_RADIUS
from tools.eval.judge import instances_of

CLEARANCE = 1.0  # m from an instance of the object
_BETWEEN = np.linspace(0.0, 1.0, 24)[1:-1]  # samples of a line of at most a metre: every 5 cm


class GoalRegion:
    """Floor within the clearance of an instance of ``noun``, with no wall or closed door between."""

    def __init__(self, house: House, noun: str):
        self._house, self._space = house, FreeSpace(house)
        self._instances = instances_of(house, noun)
        self._walls = self._space.walls()

    def distance(self, position) -> float:
        """m from ``position (2,)`` to the nearest point of an instance in line of sight; infinite without one."""
        place = np.asarray(position, float)[None]
        return min((float(self._away(thing, place)[0]) for thing in self._instances), default=np.inf)

    def shortest_path(self, start) -> float:
        """Length [m] of the shortest way from ``start (2,)`` to the region; infinite when there is none."""
        frame, free = self._space.frame, self._space.reachable(ROBOT_RADIUS, start[:2])
        rows, cols = np.nonzero(free)
        places = frame.to_world(rows, cols)
        region = np.zeros(frame.shape, bool)
        for thing in self._instances:
            region[rows, cols] |= self._away(thing, places) <= CLEARANCE
        cell = _first_met(free, tuple(int(i) for i in frame.to_cell(np.asarray(start, float)[:2])), region)
        if cell is None:
            return np.inf
        path = plan(free, frame, start, frame.to_world(*cell))
        return float(np.hypot(*np.diff(path, axis=0).T).sum())

    def _away(self, thing, places: np.ndarray) -> np.ndarray:
        """m from ``places (N, 2)`` to the outline of a thing, infinite where a wall is between or it is too far."""
        nearest = _nearest_on(thing.footprint, places)
        away = np.hypot(*(nearest - places).T)
        close = np.flatnonzero(away <= 2 * CLEARANCE)
        lines = places[close, None] + _BETWEEN[:, None] * (nearest - places)[close, None]
        row, col = self._space.frame.to_cell(lines)
        blocked = self._walls[row, col].any(axis=1)
        far = np.full(len(places), np.inf)
        far[close[~blocked]] = away[close[~blocked]]
        return far


def _nearest_on(outline: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The point of a closed ``outline (M, 2)`` nearest to each of ``places (N, 2)``: ``(N, 2)``."""
    a, b = outline, np.roll(outline, -1, axis=0)
    along = b - a
    share = ((places[:, None] - a) * along).sum(-1) / np.maximum((along * along).sum(-1), 1e-12)
    points = a + np.clip(share, 0, 1)[..., None] * along
    away = np.hypot(*np.moveaxis(points - places[:, None], -1, 0))
    return points[np.arange(len(places)), away.argmin(axis=1)]


def _first_met(free: np.ndarray, start: tuple[int, int], region: np.ndarray) -> tuple[int, int] | None:
    """The cell of ``region`` that a wave from ``start`` over ``free`` cells meets first; octagonal, 8 % off at most."""
    wave, shapes = np.zeros(free.shape, np.uint8), (cv2.MORPH_CROSS, cv2.MORPH_RECT)
    wave[start] = 1
    for step in range(free.size):
        met = np.argwhere(region & wave.view(bool))
        if len(met):
            return tuple(int(i) for i in met[0])
        grown = cv2.dilate(wave, cv2.getStructuringElement(shapes[step % 2], (3, 3))) & free.view(np.uint8)
        if (grown == wave).all():
            return None
        wave = grown
    return None
