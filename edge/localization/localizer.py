"""Where the robot is in the map: odometry, corrected by scans."""

from dataclasses import dataclass, field

import numpy as np

from edge.localization.global_search import candidates
from edge.localization.kalman import PoseBelief
from edge.localization.likelihood_field import LikelihoodField
from edge.localization.scan_matching import Match, MatchConfig, match, refine, scan_points
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan
from edge.pose import between, compose, rotation, wrap


@dataclass(frozen=True)
class LocalizerConfig:
    """Settings of the localizer."""

    match: MatchConfig = field(default_factory=MatchConfig)
    min_distance: float = 0.05  # m, one cell; standing still, a scan says nothing new
    min_angle: float = np.radians(3.0)  # rad, three beams
    slip: float = 0.02  # m per m, standard deviation of odometry along and across: carpet, tiles
    slip_angle: float = 0.02  # rad per rad turned
    drift_angle: float = 0.02  # rad per m driven
    min_score: float = 0.60  # share of returns that must fit; people and moved chairs may cost 40 %
    gate: float = 16.27  # squared Mahalanobis distance; chi-square with 3 dof exceeds it once in 1 000
    spun: tuple[float, float, float] = (0.05, 0.05, 0.05)  # m, m, rad; doubt after a good match that the gate refused
    lost_after: int = 20  # rejected matches in a row, about 1 m of driving, before the localizer calls itself lost


class Localizer:
    """Keeps the transform from map to odom: ``pose = compose(map_from_odom, odom)``.

    ``map_from_odom`` (3,) is where odometry starts in the map: at its origin, unless the map is an old one. In an old
    map a robot wakes up ``lost``: nobody knows where that is.
    """

    def __init__(
        self, map_from_odom: np.ndarray | None = None, config: LocalizerConfig | None = None, lost: bool = False
    ):
        self.config = config or LocalizerConfig()
        start = np.zeros(3) if map_from_odom is None else np.array(map_from_odom, float)
        self._belief = PoseBelief(start, np.diag([1e-6, 1e-6, 1e-6]))
        self._odom = np.zeros(3)  # odometry that the belief belongs to
        self._rejected = self.config.lost_after if lost else 0
        self.match: Match | None = None  # newest match, accepted or not
        self.fits = False  # whether the newest scan was matched and fits here, or nothing is mapped here

    @property
    def map_from_odom(self) -> np.ndarray:
        """The odom frame in the map, (3,)."""
        return compose(self._belief.mean, between(self._odom, np.zeros(3)))

    @property
    def covariance(self) -> np.ndarray:
        """Covariance (3, 3) [m², rad²] of the pose at the newest scan."""
        return self._belief.covariance

    @property
    def lost(self) -> bool:
        """Whether matches have failed for so long that only ``relocalize`` helps. A lost robot must not map."""
        return self._rejected >= self.config.lost_after

    @property
    def sure(self) -> bool:
        """Whether no match has failed since the last good one; else the robot may be elsewhere than it believes."""
        return self._rejected == 0

    def pose(self, odom: np.ndarray) -> np.ndarray:
        """Pose (3,) in the map of the base at ``odom`` (3,), now or at the stamp of any scan or frame."""
        return compose(self.map_from_odom, odom)

    def update(self, odom: np.ndarray, scan: LaserScan | None, grid: OccupancyGrid) -> np.ndarray:
        """Pose (3,) in the map of the base at ``odom`` (3,), after matching ``scan`` (if any) with ``grid``.

        The scan is matched at its own odometry, so a turning or late scan does no harm. Map the scan with
        ``grid.integrate_scan(localizer.pose(scan.odom), scan)`` afterwards only if it ``fits``: a map that takes in
        what contradicts it soon agrees with a wrong pose. A lost robot's scans are not matched: near where it is not,
        one may fit by chance.
        """
        self.fits = False
        if scan is not None:
            motion = between(self._odom, scan.odom)
            if np.hypot(*motion[:2]) >= self.config.min_distance or abs(motion[2]) >= self.config.min_angle:
                self._predict(motion, scan.odom)
                if not self.lost:
                    self._correct(scan, grid)
        return self.pose(odom)

    def move(self, before: np.ndarray, after: np.ndarray) -> None:
        """Go along with the map: what was at pose (3,) ``before`` is at ``after`` now."""
        turn = rotation(after[2] - before[2])
        mean = compose(after, between(before, self._belief.mean))
        self._belief = PoseBelief(mean, turn @ self._belief.covariance @ turn.T)

    def relocalize(self, scan: LaserScan, grid: OccupancyGrid) -> bool:
        """Looks for the robot in the whole map; True when found.

        For a robot that was carried or starts in a known home: takes up to half a second, and keeps the old pose when
        no place fits or when two different ones fit alike.
        """
        config = self.config.match
        points = scan_points(scan, config.min_range)
        if len(points) < config.min_points:
            return False
        rows, cols = grid.frame.shape
        whole = LikelihoodField.around(
            grid, grid.frame.to_world(rows // 2, cols // 2), max(rows, cols) * grid.resolution
        )
        found = [refine(whole, points, pose, config) for pose in candidates(grid, whole, points)]
        found = sorted((m for m in found if m.score >= config.good_score), key=lambda m: -m.score)
        if not found:
            return False
        best = found[0]
        rivals = [other for other in found if _differ(other.pose, best.pose)]
        if rivals and rivals[0].score > 0.95 * best.score:
            return False
        self._belief = PoseBelief(best.pose, best.covariance)
        self._odom = np.asarray(scan.odom, float)
        self._rejected, self.match = 0, best
        return True

    def _predict(self, motion: np.ndarray, odom: np.ndarray) -> None:
        distance, turn = float(np.hypot(*motion[:2])), abs(float(motion[2]))
        along = self.config.slip * distance + 1e-3
        heading = self.config.slip_angle * turn + self.config.drift_angle * distance + 5e-4
        self._belief = self._belief.moved(motion, np.diag([along**2, along**2, heading**2]))
        self._odom = np.asarray(odom, float)

    def _correct(self, scan: LaserScan, grid: OccupancyGrid) -> None:
        guess = self._belief.mean
        local = LikelihoodField.around(grid, guess, scan.range_max + 0.5)
        found = match(local, scan, guess, self.config.match)
        self.match = found
        if found.known < self.config.match.min_points:
            self.fits = True  # new ground: there is nothing yet to agree or disagree with
            return
        if found.score < self.config.min_score:
            self._rejected += 1
        elif self._belief.distance(found.pose, found.covariance) > self.config.gate:
            self._rejected += 1
            # Either this match or the odometry is wrong: wheels spin when the robot pushes against something. The
            # next matches tell, if they agree with this one.
            self._belief = PoseBelief(guess, self._belief.covariance + np.diag(self.config.spun) ** 2)
        else:
            self._rejected, self.fits = 0, True
            self._belief = self._belief.corrected(found.pose, found.covariance)


def _differ(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two poses (3,) are different places rather than one place found twice."""
    return bool(np.hypot(*(a - b)[:2]) > 0.5 or abs(wrap(a[2] - b[2])) > 0.3)
