"""Where stopping counts, and the shortest way there: the truth behind SR and SPL ([U] Sec. V)."""

from math import ceil

import cv2
import numpy as np

from edge.planning.theta_star import plan
from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.placement import ROBOT_RADIUS
from tools.eval.judge import instances_of

CLEARANCE = 1.0  # m from an instance of the object
_STEP = 0.03  # m between the points of an outline that are looked for
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

    def shows(self, place, slack: float) -> bool:
        """Whether ``place (2,)`` lies within ``slack`` [m] of an instance's outline, or on it."""
        outlines = (thing.footprint.astype(np.float32) for thing in self._instances)
        x, y = (float(value) for value in place)
        return any(cv2.pointPolygonTest(outline, (x, y), True) >= -slack for outline in outlines)

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
        """m from ``places (N, 2)`` to what walls leave to see of a thing's outline; infinite if nothing, or too far."""
        points = _points_on(thing.footprint)
        away = np.hypot(*np.moveaxis(points - places[:, None], -1, 0))
        seen = np.full(len(places), np.inf)
        left = np.flatnonzero(away.min(axis=1) <= 2 * CLEARANCE)
        order = np.argsort(away[left], axis=1)
        for rank in range(len(points)):  # a door jamb may hide the nearest point, and not the next one
            nearest = order[:, rank]
            distance = away[left, nearest]
            lines = places[left, None] + _BETWEEN[:, None] * (points[nearest] - places[left])[:, None]
            row, col = self._space.frame.to_cell(lines)
            clear = ~self._walls[row, col].any(axis=1)
            seen[left[clear]] = distance[clear]
            further = ~clear & (distance <= 2 * CLEARANCE)
            left, order = left[further], order[further]
        return seen


def _points_on(outline: np.ndarray) -> np.ndarray:
    """Points ``(M, 2)`` along a closed ``outline (K, 2)``, its corners and others not more than ``_STEP`` apart."""
    sides = zip(outline, np.roll(outline, -1, axis=0))
    return np.concatenate([np.linspace(a, b, 1 + ceil(np.hypot(*(b - a)) / _STEP), endpoint=False) for a, b in sides])


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
