"""Where a grid map lies in the world."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class GridFrame:
    """Grid ``[row = y, col = x]``; ``origin`` is the lower-left *corner* of cell [0, 0] in the map frame [m]."""

    origin: tuple[float, float]
    resolution: float  # m per cell
    shape: tuple[int, int]  # rows, cols

    def to_cell(self, xy):
        """Points ``(..., 2)`` [m] to integer (row, col), each ``(...)``; they may lie outside the shape."""
        xy = np.asarray(xy, float)
        col = np.floor((xy[..., 0] - self.origin[0]) / self.resolution).astype(np.intp)
        row = np.floor((xy[..., 1] - self.origin[1]) / self.resolution).astype(np.intp)
        return row, col

    def to_world(self, row, col):
        """Centres ``(..., 2)`` [m] of the cells (row, col)."""
        x = self.origin[0] + (np.asarray(col) + 0.5) * self.resolution
        y = self.origin[1] + (np.asarray(row) + 0.5) * self.resolution
        return np.stack([x, y], axis=-1)

    def contains(self, row, col):
        """Boolean mask of the cells (row, col) that lie inside the shape."""
        row, col = np.asarray(row), np.asarray(col)
        return (row >= 0) & (row < self.shape[0]) & (col >= 0) & (col < self.shape[1])

    def within(self, radius: float, place) -> np.ndarray:
        """Mask ``(R, C)`` of the cells whose centre lies no further than ``radius`` [m] from ``place (2,)`` [m]."""
        x = self.origin[0] + (np.arange(self.shape[1]) + 0.5) * self.resolution - place[0]
        y = self.origin[1] + (np.arange(self.shape[0]) + 0.5) * self.resolution - place[1]
        return (x**2)[None] + (y**2)[:, None] <= radius**2

    def holding(self, array: np.ndarray, old: "GridFrame | None", empty) -> np.ndarray:
        """What ``array`` (R, C) has on the frame ``old``, on this one, which contains it; ``empty`` elsewhere.

        For layers that follow a grid as it grows. Without an ``old`` frame all is empty.
        """
        grown = np.full(self.shape, empty, array.dtype)
        if old is not None:
            row, col = self.to_cell(old.to_world(0, 0))
            grown[row : row + array.shape[0], col : col + array.shape[1]] = array
        return grown
