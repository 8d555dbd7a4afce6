"""The 2-D lidar: distances to wall faces and to furniture cut at its height."""

from dataclasses import dataclass
from math import pi

import numpy as np

from edge.pose import transform
from firmware_sim.pedestrian import Figure
from firmware_sim.polygons import edges


@dataclass(frozen=True)
class LidarConfig:
    """A small spinning lidar in the middle of the base."""

    beams: int = 360  # over the full circle
    height: float = 0.25  # m above the floor
    range_max: float = 8.0  # m
    noise: float = 0.01  # m, standard deviation of a distance

    @property
    def angle_min(self) -> float:
        return -pi

    @property
    def angle_increment(self) -> float:
        return 2 * pi / self.beams


class Lidar:
    """Casts all beams at once against the house as it stands; notices objects that were moved."""

    def __init__(self, house, config: LidarConfig, rng: np.random.Generator | None):
        """``rng`` draws the noise of the distances; None measures exactly."""
        self.house, self.config, self._rng = house, config, rng
        self._revision = None
        self._segments = np.zeros((0, 2, 2))

    def scan(self, pose, figure: Figure | None = None) -> np.ndarray:
        """Distances ``(beams,)`` float32 [m] from the true base pose ``(3,)``; inf where nothing is in range.

        ``figure`` is a person who stands in the house at the moment.

        Works per segment, not per beam: a segment covers a run of neighbouring beams, and only these are intersected
        with it. So the work is the number of beams times how many surfaces lie behind one another, not times all.
        """
        if self._revision != self.house.revision:
            self._segments, self._revision = self._cut(), self.house.revision
        config = self.config
        x, y, theta = pose
        a = self._segments[:, 0] - (x, y)
        along = self._segments[:, 1] - self._segments[:, 0]
        # Distance of the segment from the lidar, to leave out what is too far.
        share = -(a * along).sum(1) / np.maximum((along * along).sum(1), 1e-12)
        nearest = a + np.clip(share, 0.0, 1.0)[:, None] * along
        seen = (nearest * nearest).sum(1) < config.range_max**2
        a, along = a[seen], along[seen]
        ends = a + along
        # A segment subtends less than half a turn: start at the end from which it opens counter-clockwise.
        cross = a[:, 0] * ends[:, 1] - a[:, 1] * ends[:, 0]
        dot = (a * ends).sum(1)
        opening = np.abs(np.arctan2(cross, dot))
        first_end = np.where((cross >= 0)[:, None], a, ends)
        start = np.arctan2(first_end[:, 1], first_end[:, 0]) - theta - config.angle_min
        first = np.ceil(start / config.angle_increment)
        count = np.maximum(np.floor((start + opening) / config.angle_increment) - first + 1, 0).astype(np.intp)
        # One row for each pair of a segment and a beam that meets it.
        segment = np.repeat(np.arange(len(count)), count)
        step = np.arange(len(segment)) - np.repeat(np.cumsum(count) - count, count)
        beam = first.astype(np.intp)[segment] + step
        angle = beam * config.angle_increment + config.angle_min + theta
        across = np.cos(angle) * along[segment, 1] - np.sin(angle) * along[segment, 0]
        numerator = (a[:, 0] * along[:, 1] - a[:, 1] * along[:, 0])[segment]
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = numerator / across
        distance[~(distance > 0)] = np.inf  # a beam along the segment: its neighbours tell
        ranges = np.full(config.beams, np.inf)
        np.minimum.at(ranges, beam % config.beams, distance)
        if figure is not None:
            angles = theta + config.angle_min + config.angle_increment * np.arange(config.beams)
            beams = np.stack([np.cos(angles), np.sin(angles)], axis=1)
            ranges = np.minimum(ranges, figure.distances(x, y, beams))
        if self._rng is not None:
            ranges += self._rng.normal(0.0, config.noise, config.beams)
        ranges[ranges > config.range_max] = np.inf
        return np.maximum(ranges, 0.0).astype(np.float32)

    def _cut(self) -> np.ndarray:
        """All segments ``(N, 2, 2)`` in the lidar's plane.

        The pack holds each model's cut at 0.25 m above its own base; of a thing that is raised, and still reaches
        through the plane, the footprint's outline stands in for the cut.
        """
        parts = [self.house.wall_segments()]
        for thing in self.house.objects.values():
            low, high = thing.height_range
            if low == 0.0 and len(thing.model.slices):
                parts.append(transform(thing.pose, np.reshape(thing.model.slices, (-1, 2))).reshape(-1, 2, 2))
            elif 0.0 < low < self.config.height < high:
                parts.append(edges(thing.footprint))
        return np.concatenate(parts)
