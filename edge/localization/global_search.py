"""Where in a whole map a scan may have been taken, without a guess."""

import cv2
import numpy as np

from edge.localization.likelihood_field import LikelihoodField
from edge.mapping.occupancy import OccupancyGrid

_CELL = 4  # map cells to a side of a search cell: 0.2 m
_TURNS = 72  # headings: 5 deg
_POINTS = 90  # returns used
_KEPT = 40  # poses handed on to refinement
_SIGMA = 0.20  # m, width of the fit: half a search cell and half a turn at 3 m


def candidates(grid: OccupancyGrid, field: LikelihoodField, points: np.ndarray) -> np.ndarray:
    """The ``(K, 3)`` best places for ``points`` (N, 2) [m] in base_link, on a lattice of 0.2 m and 5° over free ground.

    ``field`` covers the whole ``grid``.
    """
    fit = np.pad(np.exp(-0.5 * (field.distance / _SIGMA) ** 2), 1)
    frame = grid.frame
    rows, cols = (np.arange(_CELL // 2, size, _CELL) for size in frame.shape)
    row, col = (index.reshape(-1) for index in np.meshgrid(rows, cols, indexing="ij"))
    places = frame.to_world(row, col)
    places = places[cv2.erode(grid.free.view(np.uint8), np.ones((3, 3), np.uint8))[row, col] > 0]
    points = points[:: max(1, len(points) // _POINTS)]
    scores = np.empty((_TURNS, len(places)), np.float32)
    turns = np.arange(_TURNS) * (2 * np.pi / _TURNS)
    start = (places - field.frame.origin) / frame.resolution + 1
    for scored, turn in zip(scores, turns):
        cos, sin = np.cos(turn), np.sin(turn)
        turned = points @ np.array([[cos, sin], [-sin, cos]]) / frame.resolution
        x = np.clip((start[:, :1] + turned[:, 0]).astype(np.int32), 0, fit.shape[1] - 1)
        y = np.clip((start[:, 1:] + turned[:, 1]).astype(np.int32), 0, fit.shape[0] - 1)
        scored[:] = fit[y, x].sum(axis=1)
    best = np.argpartition(-scores, min(_KEPT, scores.size) - 1, axis=None)[:_KEPT] if scores.size else np.empty(0, int)
    turn, place = np.unravel_index(best, scores.shape)
    return np.concatenate([places[place], turns[turn][:, None]], axis=1)
