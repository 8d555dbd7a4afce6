"""How likely each place is near what is sought: a Gaussian in every cell, updated in closed form ([U] Eqs. 5-8)."""

from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.view_fan import fill, view_fan


@dataclass(frozen=True)
class RelevanceConfig:
    """The prior of a cell, and how much a view says about what it shows."""

    mean: float = 0.5  # prior of a relevance in [0, 1], [U] Sec. IV
    variance: float = 0.5  # prior, [U] Sec. IV
    off_axis: float = 0.05  # kappa, the variance that a view has at its edge beside that of the prompts
    floor: float = 1e-4  # variance that is left when all prompts agree: seven prompts are no proof
    range: float = 5.0  # m, the camera's own
    columns: int = 640  # of the depth image


class RelevanceMap:
    """Mean and variance of the relevance in each cell; they follow the occupancy grid as it grows."""

    def __init__(self, config: RelevanceConfig | None = None):
        self.config = config or RelevanceConfig()
        self.frame: GridFrame | None = None
        self.mean = np.zeros((0, 0), np.float32)
        self.variance = np.zeros((0, 0), np.float32)

    def integrate(self, pose, depth, relevance, camera: CameraModel, grid: OccupancyGrid) -> None:
        """Take in a view from ``pose (3,)``: its ``depth (H, W)`` [m] and the relevance by each prompt, ``(P,)``.

        It counts in the cells that the view looks over, up to what hides the rest. [U] Eq. 5, corrected: the confidence
        of a cell at angle t from the axis is cos(pi t / fov)^2, 1 ahead and 0 at the picture's edge; as printed, with
        2 pi, it is 0 halfway.
        """
        self.follow(grid.frame)
        seen = np.zeros(self.frame.shape, np.uint8)
        fan = view_fan(pose, depth, camera, grid, min(self.config.columns, depth.shape[1]), self.config.range)
        fill(seen, self.frame, fan)
        low = self.frame.to_cell(fan.min(axis=0))
        high = self.frame.to_cell(fan.max(axis=0))
        rows, cols = (slice(max(int(a), 0), int(b) + 1) for a, b in zip(low, high))
        inside = np.nonzero(seen[rows, cols])
        row, col = inside[0] + rows.start, inside[1] + cols.start
        x, y = self.frame.to_world(row, col).T - fan[0][:, None]
        bearing = np.arctan2(y, x) - pose[2]
        bearing = np.clip(np.arctan2(np.sin(bearing), np.cos(bearing)), -camera.hfov / 2, camera.hfov / 2)
        confidence = np.cos(np.pi * bearing / camera.hfov) ** 2
        self.fuse((row, col), np.asarray(relevance, float), confidence)

    def fuse(self, cells, relevance: np.ndarray, confidence: np.ndarray) -> None:
        """Update ``cells``, the indices of N of them, by a view's relevances ``(P,)`` and their ``confidence (N,)``.

        [U] Eqs. 3-4: mean and variance over the prompts. Eq. 6, corrected: the variance is that of the prompts plus
        ``off_axis`` times one minus the confidence; printed without the factor, half a degree off the axis the prompts
        would no longer matter. Eqs. 7-8: product of two Gaussians.
        """
        spread = max(float(relevance.var()), self.config.floor)
        noise = (spread + self.config.off_axis * (1 - confidence)).astype(np.float32)
        mean, variance = self.mean[cells], self.variance[cells]
        total = variance + noise
        self.mean[cells] = (noise * mean + variance * np.float32(relevance.mean())) / total
        self.variance[cells] = variance * noise / total

    def follow(self, frame: GridFrame) -> None:
        """Take on the shape of a grid that has grown; new cells have the prior."""
        if frame != self.frame:
            self.mean = frame.holding(self.mean, self.frame, self.config.mean)
            self.variance = frame.holding(self.variance, self.frame, self.config.variance)
            self.frame = frame

    def around(self, place, radius: float) -> tuple[float, float]:
        """Median of mean and of variance over a disc of ``radius`` [m] around ``place (2,)`` [m] ([U] Sec. IV)."""
        cells = self.disc(place, radius)
        return float(np.median(self.mean[cells])), float(np.median(self.variance[cells]))

    def disc(self, place, radius: float) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the cells within ``radius`` [m] of ``place (2,)`` [m]."""
        row, col = self.frame.to_cell(place)
        cells = int(np.ceil(radius / self.frame.resolution))
        down, right = np.mgrid[-cells : cells + 1, -cells : cells + 1]
        disc = down**2 + right**2 <= (radius / self.frame.resolution) ** 2
        rows, cols = row + down[disc], col + right[disc]
        inside = self.frame.contains(rows, cols)
        return rows[inside], cols[inside]
