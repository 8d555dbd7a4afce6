"""The point of an object that the robot drives to, from its mask in a picture and the depth there ([U] Sec. IV)."""

from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.sight_line import mapped_depth
from edge.perception.detection import Detection
from edge.pose import transform


@dataclass(frozen=True)
class ObjectGoalConfig:
    """When a place can be trusted, and when two places are one object's."""

    edge: float = 2.0  # px; a mask that is so near to the picture's left or right edge may go on beyond it
    far: float = 0.95  # of the camera's range; beyond, depth may be that of nothing
    nearer: float = 0.1  # m beyond the camera's least depth, within which the map's obstacles may be too near for it
    thick: float = 0.5  # m; the mask's pixels in the fullest slice so thick are the object's
    behind: float = 0.25  # of the mask's pixels, if so many lie beyond that slice, the object may be there instead
    same: float = 1.0  # m between the centroids of two views of one object
    shift: float = 0.3  # m that the nearest point must move before the goal does


CONFIG = ObjectGoalConfig()
STRIDE = 4  # pixels between the points of a surface


@dataclass(frozen=True, slots=True)
class Surface:
    """What one picture shows of an object."""

    points: np.ndarray  # (N, 2) m, map frame
    provisional: bool  # cut by the picture's edge, or too far away: to be seen from closer before it counts
    behind: "Surface | None" = None  # where the object is if what the mask shows most of only stands before it
    vague: bool = False  # too far away, or mostly without depth: a direction rather than a place
    origin: np.ndarray | None = None  # (2,) m, where the robot saw it from

    @property
    def centroid(self) -> np.ndarray:
        """(2,) m."""
        return self.points.mean(axis=0)


def surface(detection: Detection, depth, camera: CameraModel, pose, grid: OccupancyGrid, config=CONFIG) -> Surface:
    """The points that the ``detection`` covers in ``depth (H, W)`` [m], taken from ``pose (3,)``.

    Where its mask has no return, it is nearer than the camera measures, if the map has something there, or further.
    """
    (x0, y0, x1, _), mask = detection.box, detection.mask
    stride = STRIDE if mask[::STRIDE, ::STRIDE].any() else 1  # a small mask may lie between the points
    rows, cols = np.nonzero(mask[::stride, ::stride])
    u, ranges = cols * stride + int(x0), depth[rows * stride + int(y0), cols * stride + int(x0)]
    blank = ~(np.isfinite(ranges) & (ranges > 0))
    columns, column = np.unique(u[blank], return_inverse=True)
    mapped = mapped_depth(grid, camera, pose, columns)[column]
    ranges[blank] = np.where(mapped <= camera.min_depth + config.nearer, mapped, camera.max_depth)
    order = np.argsort(ranges)
    u, ranges, blank = u[order], ranges[order], blank[order]
    ends = np.searchsorted(ranges, ranges + config.thick, side="right")
    first = int(np.argmax(ends - np.arange(len(ranges))))
    last = int(ends[first])
    far = np.median(ranges[first:last]) > config.far * camera.max_depth
    cut = x0 <= config.edge or x1 >= depth.shape[1] - config.edge
    behind = None
    if len(u) - last > config.behind * len(u):
        behind = Surface(_on_floor(u[last:], ranges[last:], camera, pose), True, origin=pose[:2])
    vague = bool(far or blank[first:last].mean() > 0.5)
    return Surface(_on_floor(u[first:last], ranges[first:last], camera, pose), vague or cut, behind, vague, pose[:2])


def _on_floor(u, ranges, camera: CameraModel, pose) -> np.ndarray:
    """Points ``(N, 2)`` [m] of the map below what pixel columns ``u (N,)`` show at depths ``ranges (N,)`` [m]."""
    return transform(pose, camera.unproject(u, camera.centre[1], ranges)[:, :2])


class ObjectGoal:
    """Where an object seems to be. Firm views replace provisional ones, later views earlier ones."""

    def __init__(self, seen: Surface, config: ObjectGoalConfig = CONFIG):
        self.config = config
        self._seen = seen
        self._goal: np.ndarray | None = None

    @property
    def provisional(self) -> bool:
        """Whether no view so far shows where the object ends."""
        return self._seen.provisional

    @property
    def centroid(self) -> np.ndarray:
        """(2,) m, the middle of what is seen of it."""
        return self._seen.centroid

    def is_at(self, place) -> bool:
        """Whether a view with its centroid at ``place (2,)`` [m] is one of this object."""
        return bool(np.hypot(*(self.centroid - place)) <= self.config.same)

    @property
    def origin(self) -> np.ndarray | None:
        """(2,) m, where the robot last saw it from."""
        return self._seen.origin

    @property
    def behind(self) -> Surface | None:
        """Where it is if what seems to be its surface only stands before it."""
        return self._seen.behind

    def update(self, seen: Surface) -> None:
        """Another view of it."""
        if self.provisional and not seen.provisional:
            self._goal = None  # that was no place to keep to
        if self.provisional or not seen.provisional:
            self._seen = seen

    def nearest(self, position) -> np.ndarray:
        """Its point (2,) [m] nearest to ``position (2,)``; it stays where it was while that moves by little."""
        points = self._seen.points
        point = points[np.argmin(np.hypot(*(points - np.asarray(position)[:2]).T))]
        if self._goal is None or np.hypot(*(point - self._goal)) > self.config.shift:
            self._goal = point
        return self._goal
