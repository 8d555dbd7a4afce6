"""People and other things that move, as the lidar shows them: returns from ground that the map knows to be free."""

from dataclasses import dataclass, replace

import numpy as np

from edge.camera import CameraModel
from edge.localization.scan_matching import returned, scan_points
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan
from edge.perception.constant_velocity import ConstantVelocity
from edge.planning.dbscan import dbscan
from edge.pose import transform, wrap


@dataclass(frozen=True)
class MoverConfig:
    """What counts as a body, and how it is followed."""

    min_range: float = 0.10  # m; nearer returns are the robot itself
    reach: float = 5.0  # m; a person further off is met by fewer than six beams of 1°
    off: float = 0.15  # m from all that is mapped: a wall is never seen this far off. A known body may come nearer
    doubt: float = 0.35  # share of returns on free ground above which it is the pose that is wrong
    gap: float = 0.30  # m between returns of one body: two legs
    min_returns: int = 3
    width: float = 0.90  # m; what is wider is furniture or a wall not mapped yet
    edge: float = 0.03  # m that a body is wider than its outermost beams say
    noise: float = 0.05  # m, one sigma of a body's middle, of which the lidar sees one side
    speed: float = 1.2  # m/s, one sigma of a new body's velocity: it may be a thing, or somebody in a hurry
    acceleration: float = 1.5  # m/s², one sigma: a person stops or starts within half a second
    gate: float = 13.8  # squared Mahalanobis distance, chi-square with 2 degrees of freedom at 99.9 %
    step: float = 0.20  # m from its last place, four sigmas: it moves ...
    settle: float = 0.8  # s ... unless that, or its coming into sight, is so long ago; then it is mapped like furniture
    person: float = 0.25  # m, least radius of what moves or may
    around: float = 0.20  # m around a body: arms and swinging legs, and how far its tracked place may be off
    hides: float = 3.0  # m; a person nearer than this covers a tenth of a picture or more
    forget: float = 1.0  # s without a return: behind a cupboard a person walks on, and comes out again


@dataclass(frozen=True, slots=True)
class Mover:
    """A body that the map does not show, now. What it does next is planning's guess."""

    position: np.ndarray  # (2,) m in the map, its middle
    velocity: np.ndarray  # (2,) m/s
    doubt: float  # m/s, one sigma of its velocity
    radius: float  # m


class MoverTracker:
    """Finds bodies in scans and follows each with a filter of constant velocity."""

    def __init__(self, config: MoverConfig | None = None):
        self.config = config or MoverConfig()
        self._tracks: list[_Track] = []
        self._stamp = 0.0

    @property
    def followed(self) -> list[Mover]:
        """Every body that is followed, moving or not, where it is at the newest scan."""
        return [self._mover(track) for track in self._tracks]

    @property
    def anybody(self) -> bool:
        """Whether something moves."""
        return any(map(self._walks, self._tracks))

    @property
    def discs(self) -> np.ndarray:
        """What the camera must not map: discs ``(M, 3)``, x, y and radius [m], around bodies that move or are new."""
        passing = filter(self._passes, self._tracks)
        around = [[*track.filter.position, self._radius(track) + self.config.around] for track in passing]
        return np.array(around, float).reshape(-1, 3)

    def touch(self, pose: np.ndarray, radius: float) -> bool:
        """Whether a robot of ``radius`` [m] at ``pose`` (3,) may be touching one of the bodies."""
        reach = radius + self.config.around
        return any(np.hypot(*(mover.position - pose[:2])) < reach + mover.radius for mover in self.followed)

    def hide(self, pose: np.ndarray, camera: CameraModel) -> bool:
        """Whether somebody walks through the near part of what ``camera`` sees from base ``pose`` (3,)."""
        for track in filter(self._walks, self._tracks):
            x, y = track.filter.position - pose[:2]
            away, bearing = np.hypot(x, y), wrap(np.arctan2(y, x) - pose[2])
            if away < self.config.hides and abs(bearing) < camera.hfov / 2 + np.arctan2(track.radius, away):
                return True
        return False

    def update(self, pose: np.ndarray, scan: LaserScan, grid: OccupancyGrid) -> None:
        """Takes in a scan made at ``pose`` (3,) in the map of ``grid``, which must not contain it yet."""
        for track in self._tracks:
            track.filter.predict(max(0.0, scan.stamp - self._stamp))
            track.beams = np.zeros(0, np.intp)
        self._stamp = scan.stamp
        for beams, points in self._bodies(pose, scan, grid):
            self._assign(beams, _middle(points, pose[:2], self.config.edge))
        self._tracks = [track for track in self._tracks if not self._gone(track)]

    def without_walkers(self, scan: LaserScan) -> LaserScan:
        """The newest scan, as if the beams that ended on bodies that walk had told nothing.

        What is new and stands is left in it: in an unknown home that is furniture, which the localization needs. Who
        then walks off leaves lidar marks that the next turns clear, unlike the camera's (see ``discs``).
        """
        beams = [track.beams for track in self._tracks if self._walks(track)]
        if not any(map(len, beams)):
            return scan
        ranges = np.array(scan.ranges)
        ranges[np.concatenate(beams)] = np.nan
        return replace(scan, ranges=ranges)

    def _bodies(self, pose, scan, grid):
        """Beams and their ends in the map, ``(N,)`` and ``(N, 2)``, for each body in the scan."""
        config = self.config
        beams, points = returned(scan, config.min_range), transform(pose, scan_points(scan, config.min_range))
        row, col = grid.frame.to_cell(points)
        known = grid.frame.contains(row, col)
        row, col = np.where(known, row, 0), np.where(known, col, 0)
        expected = np.zeros(len(points), bool)
        for mover in self.followed:
            expected |= np.hypot(*(points - mover.position).T) < mover.radius + config.around
        off = np.where(expected, grid.resolution, config.off)
        strange = known & grid.free[row, col] & (grid.clearance()[row, col] > off)
        if strange.sum() > config.doubt * len(points):
            return
        strange &= np.hypot(*(points - pose[:2]).T) < config.reach
        beams, points = beams[strange], points[strange]
        labels = dbscan(points, config.gap, config.min_returns)
        for label in range(labels.max(initial=-1) + 1):
            body = points[labels == label]
            if np.hypot(*np.ptp(body, axis=0)) <= config.width:
                yield beams[labels == label], body

    def _assign(self, beams, body: tuple[np.ndarray, float]) -> None:
        """Gives a body's middle and radius to the track that expects it most, or starts one."""
        middle, radius = body
        config = self.config
        noise = config.noise + max(config.person - radius, 0.0)  # what is seen in part has its middle elsewhere
        waiting = [track for track in self._tracks if not len(track.beams)]
        nearest = min(waiting, key=lambda track: track.filter.distance(middle, noise), default=None)
        if nearest is None or nearest.filter.distance(middle, noise) > config.gate:
            begun = ConstantVelocity(middle, noise, config.speed, config.acceleration)
            self._tracks.append(_Track(begun, middle, self._stamp, self._stamp, self._stamp, radius, beams))
            return
        nearest.filter.correct(middle, noise)
        if np.hypot(*(nearest.filter.position - nearest.place)) > config.step:
            nearest.place, nearest.left = nearest.filter.position, self._stamp
        nearest.seen, nearest.radius, nearest.beams = self._stamp, max(nearest.radius, radius), beams

    def _gone(self, track: "_Track") -> bool:
        """Whether a body has been out of sight for long, or was part of another that is in sight."""
        if len(track.beams):
            return False
        seen = (other for other in self._tracks if len(other.beams))
        apart = (np.hypot(*(other.filter.position - track.filter.position)) - other.radius for other in seen)
        return self._stamp - track.seen > self.config.forget or min(apart, default=np.inf) < self.config.around

    def _passes(self, track: "_Track") -> bool:
        """Whether a body moves, or is new and may."""
        return self._stamp - track.left < self.config.settle

    def _walks(self, track: "_Track") -> bool:
        """Whether a body has moved in sight, and just now."""
        return track.left > track.born and self._passes(track)

    def _mover(self, track: "_Track") -> Mover:
        if not self._passes(track):
            return Mover(track.filter.position, np.zeros(2), 0.0, track.radius)
        doubt = float(np.sqrt(np.trace(track.filter.covariance[2:, 2:]) / 2))
        return Mover(track.filter.position, track.filter.velocity, doubt, self._radius(track))

    def _radius(self, track: "_Track") -> float:
        """m; of somebody who comes round a corner only a part is seen at first."""
        return max(track.radius, self.config.person) if self._passes(track) else track.radius


@dataclass
class _Track:
    """One body over time."""

    filter: ConstantVelocity
    place: np.ndarray  # (2,) m, where it was last found to have come to
    left: float  # s, when that was
    born: float  # s
    seen: float  # s, of the newest scan that shows it
    radius: float  # m, as much of it as any scan has shown
    beams: np.ndarray  # (N,) of the newest scan that ended on it


def _middle(points: np.ndarray, eye: np.ndarray, edge: float) -> tuple[np.ndarray, float]:
    """Middle (2,) and radius [m] of a round body whose near side ``points`` (N, 2) were seen from ``eye`` (2,).

    Over its width, the near side of a cylinder lies π/4 of its radius before its middle.
    """
    centroid = points.mean(axis=0)
    line = (centroid - eye) / np.hypot(*(centroid - eye))
    radius = np.ptp((points - centroid) @ (-line[1], line[0])) / 2 + edge
    return centroid + np.pi / 4 * radius * line, float(radius)
