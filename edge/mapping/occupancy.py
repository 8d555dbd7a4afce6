"""The occupancy grid: what the lidar and the depth camera say about each 5 cm of floor."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.mapping import log_odds, map_bytes
from edge.mapping.depth_view import DepthView, DepthViewConfig
from edge.mapping.grid import GridFrame
from edge.mapping.log_odds import LogOddsConfig
from edge.mapping.rays import draw_rays, fill_fan
from edge.mapping.warp import carried, sources, warped
from edge.observation import LaserScan
from edge.pose import transform

NO_DISCS = np.zeros((0, 3))


@dataclass(frozen=True)
class OccupancyConfig:
    """Settings of the grid."""

    lidar: LogOddsConfig = field(default_factory=LogOddsConfig)
    depth: LogOddsConfig = field(default_factory=LogOddsConfig)
    view: DepthViewConfig = field(default_factory=DepthViewConfig)
    chunk: int = 64  # cells; the grid grows by whole chunks, 3.2 m, so that it rarely copies
    max_extent: float = 100.0  # m; a larger home means a broken pose, not a mansion
    min_range: float = 0.10  # m; nearer lidar returns are the robot itself
    min_pixels: int = 2  # sampled depth pixels in a cell that make a hit; fewer are edge artefacts
    bumper_width: float = 0.9  # rad, arc in front of the robot that one contact blocks
    spare: int = 8  # cells around what a map that moves is expected to need: it may bend a little
    body_radius: float = 0.13  # m; inside the robot (0.18 m) less a cell, the ground under it is free


class OccupancyGrid:
    """Log-odds grid in layers that grows as the robot moves; ``[row = y, col = x]``, cells of ``resolution`` m.

    The lidar sees table legs and the camera sees table tops, so each sensor clears its own layer only, and a third one
    keeps what the bumper has met: a cell is *occupied* when any layer says so, *free* when lidar or camera is below
    even odds and none above, else *unknown*. Memory is three bytes a cell (0.5 MB for 20x20 m). Indices change when the
    grid grows: take ``frame`` with the arrays.
    """

    def __init__(self, resolution: float = 0.05, config: OccupancyConfig | None = None):
        if not resolution > 0:
            raise ValueError(f"The resolution must be positive, in metres a cell; got {resolution}.")
        self.config = config or OccupancyConfig()
        self.resolution = float(resolution)
        chunk = self.config.chunk
        self._corner = np.array([-chunk, -chunk])  # (row, col) of array cell [0, 0], counted from the map's origin
        self._lidar = np.zeros((2 * chunk, 2 * chunk), np.int8)
        self._depth = np.zeros_like(self._lidar)
        self._contact = np.zeros_like(self._lidar)  # 1 where the bumper met something
        self._cache: dict = {}  # of what follows from the layers, until they change

    @property
    def frame(self) -> GridFrame:
        """Where the arrays lie now."""
        y, x = (self._corner * self.resolution).tolist()
        return GridFrame((x, y), self.resolution, self._lidar.shape)

    @property
    def lidar(self) -> np.ndarray:
        """Lidar layer, int8 ``(H, W)`` in counts of ``log_odds.STEP``; read-only view."""
        return _read_only(self._lidar)

    @property
    def depth(self) -> np.ndarray:
        """Depth camera layer, int8 ``(H, W)`` in counts of ``log_odds.STEP``; read-only view."""
        return _read_only(self._depth)

    def integrate_scan(self, pose: np.ndarray, scan: LaserScan) -> None:
        """Adds one lidar turn taken at ``pose`` (3,) in the map frame.

        A beam of infinite range clears up to ``range_max``, but no further than its neighbours saw, as a single one is
        a dropout rather than open space; NaN says nothing. Raises ValueError for a pose not finite or far outside.
        """
        pose = _finite(pose)
        ranges = np.asarray(scan.ranges, float)
        with np.errstate(invalid="ignore"):
            hit = (ranges >= self.config.min_range) & (ranges < scan.range_max)
            out = ranges >= scan.range_max
        seen = np.where(hit, ranges, 0.0)
        beyond = np.where(out, scan.range_max, seen)
        seen = np.where(out, np.minimum(np.roll(beyond, 1), np.roll(beyond, -1)), seen)
        angles = pose[2] + scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        tips = pose[:2] + directions * seen[:, None]

        window, corner = self._window(tips, pose)
        apex = self._cells(pose[:2], corner)
        layer = self._lidar[window]
        hits, misses, between = (np.zeros(layer.shape, np.uint8) for _ in range(3))
        row, col = self._index(tips[hit], corner)
        hits[row, col] = 1
        lengths = np.maximum(np.where(hit, seen / self.resolution - 0.5, seen / self.resolution), 0.0)
        draw_rays(misses, apex, apex + directions * lengths[:, None])
        fill_fan(between, apex, directions, lengths)
        # Far out the beams are several cells apart. What lies between them is taken for free until measured: once, so
        # that a table leg that most turns pass by is not washed out.
        misses |= between & (layer == 0)
        log_odds.update(layer, hits, misses, self.config.lidar)
        self._cache.clear()

    def integrate_depth(
        self, pose: np.ndarray, depth: np.ndarray, camera: CameraModel, leave_out: np.ndarray = NO_DISCS
    ) -> None:
        """Adds one depth image ``(H, W)`` float32 m (0 or NaN = no return) taken at base ``pose`` (3,) in the map.

        Obstacles are points 0.1–1.0 m above the floor; see ``DepthView`` for what is cleared. The ground under
        the robot is cleared too: it stands there. What is seen in ``leave_out`` (M, 3), discs of
        x, y and radius [m], makes no hits. Raises ValueError for a wrong image size or pose.
        """
        pose = _finite(pose)
        view = DepthView.read(depth, camera, self.config.view, self.resolution)
        obstacles, start, end = (transform(pose, part) for part in (view.obstacles, view.clear_from, view.clear_to))
        window, corner = self._window(np.concatenate([obstacles, start, end]), pose)
        layer = self._depth[window]
        for x, y, radius in leave_out:
            obstacles = obstacles[np.hypot(*(obstacles - (x, y)).T) > radius]
        row, col = self._index(obstacles, corner)
        pixels = np.bincount(row * layer.shape[1] + col, minlength=layer.size).reshape(layer.shape)
        hits = (pixels >= self.config.min_pixels).astype(np.uint8)
        misses = np.zeros(layer.shape, np.uint8)
        draw_rays(misses, self._cells(start, corner), self._cells(end, corner))
        row, col = self._index(pose[None, :2], corner)
        cv2.circle(misses, (int(col[0]), int(row[0])), int(self.config.body_radius / self.resolution), 1, cv2.FILLED)
        log_odds.update(layer, hits, misses, self.config.depth)
        self._cache.clear()

    def integrate_contact(self, pose: np.ndarray, radius: float) -> None:
        """Marks what a robot of ``radius`` [m] at ``pose`` (3,) has run into: it drives forwards, so it is in front.

        A shoe is too low for the lidar and for the camera's obstacles; the bumper tells, and no other sensor unsays it.
        """
        pose = _finite(pose)
        angles = pose[2] + np.linspace(-self.config.bumper_width / 2, self.config.bumper_width / 2, 9)
        met = pose[:2] + (radius + self.resolution / 2) * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        window, corner = self._window(met, pose)
        row, col = self._index(met, corner)
        self._contact[window][row, col] = 1
        self._cache.clear()

    def forget_contacts(self) -> None:
        """Whatever the bumper has met may have been taken away; it would block its place for ever."""
        self._contact[:] = 0
        self._cache.clear()

    @property
    def occupied(self) -> np.ndarray:
        """Cells with an obstacle, bool ``(H, W)``, read-only."""
        return self._cached("occupied", lambda: (self._lidar > 0) | (self._depth > 0) | (self._contact > 0))

    @property
    def free(self) -> np.ndarray:
        """Cells seen to be clear, bool ``(H, W)``, read-only."""
        return self._cached("free", lambda: ((self._lidar < 0) | (self._depth < 0)) & ~self.occupied)

    @property
    def unknown(self) -> np.ndarray:
        """Cells that nothing is known of, bool ``(H, W)``, read-only."""
        return self._cached("unknown", lambda: ~(self.free | self.occupied))

    @property
    def area(self) -> float:
        """Floor known to be free [m²]."""
        return float(np.count_nonzero(self.free)) * self.resolution**2

    def clearance(self) -> np.ndarray:
        """Distance [m] from each cell's centre to that of the nearest occupied cell, float32 ``(H, W)``, read-only.

        Within 2 % (5x5 chamfer mask; the exact transform takes three times as long). Without any occupied cell, the
        diagonal of the grid.
        """
        return self._cached("clearance", self._clearance)

    def traversable(self, radius: float) -> np.ndarray:
        """Free cells where a disc of ``radius`` [m] touches nothing known, bool ``(H, W)``, read-only."""
        return self._cached(("traversable", radius), lambda: self.free & (self.clearance() >= radius))

    def moved(self, before: np.ndarray, after: np.ndarray) -> tuple["OccupancyGrid", np.ndarray, np.ndarray]:
        """This map, taken along with nodes whose poses ``before`` (N, 3) were corrected to ``after`` (N, 3).

        And the ``warp.sources`` it was made by, for what else lies in its frame. Raises ValueError when it would span
        more than ``max_extent``.
        """
        grid = OccupancyGrid(self.resolution, self.config)
        grid._corner = self._corner
        grid._lidar, grid._depth, grid._contact = self._lidar, self._depth, self._contact
        known = np.argwhere(~self.unknown)
        if len(known):
            # A node that turns takes what is far from it further than itself.
            hull = cv2.convexHull(known.astype(np.int32))[:, 0]
            there = self.frame.to_cell(carried(self.frame.to_world(*hull.T), before, after))
            there = np.concatenate([hull, np.stack(there, axis=-1)])
            spare = self.config.spare
            grid._grow(self._corner + there.min(0) - spare, self._corner + there.max(0) + spare)
        column, row = sources(grid.frame, before, after)
        layers = grid._lidar, grid._depth, grid._contact
        grid._lidar, grid._depth, grid._contact = (warped(layer, column, row) for layer in layers)
        return grid, column, row

    def to_bytes(self) -> bytes:
        """The map as bytes (see ``map_bytes``), for ``from_bytes``."""
        return map_bytes.pack(self.resolution, self._corner, np.stack([self._lidar, self._depth, self._contact]))

    @classmethod
    def from_bytes(cls, data: bytes, config: OccupancyConfig | None = None) -> "OccupancyGrid":
        """The map that ``to_bytes`` wrote. Raises ValueError when the bytes are damaged or from another version."""
        resolution, corner, layers = map_bytes.unpack(data)
        grid = cls(resolution, config)
        grid._corner = corner
        grid._lidar, grid._depth, grid._contact = (np.ascontiguousarray(layer) for layer in layers)
        return grid

    def _clearance(self) -> np.ndarray:
        distance = cv2.distanceTransform((~self.occupied).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
        distance *= self.resolution
        return np.minimum(distance, np.float32(np.hypot(*self._lidar.shape) * self.resolution), out=distance)

    def _cached(self, key, compute) -> np.ndarray:
        if key not in self._cache:
            self._cache[key] = _read_only(compute())
        return self._cache[key]

    def _cells(self, xy: np.ndarray, corner: np.ndarray) -> np.ndarray:
        """Points ``(..., 2)`` x, y [m] in cells from ``corner`` (row, col)."""
        return xy / self.resolution - corner[::-1]

    def _index(self, xy: np.ndarray, corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Integer row and col of points ``(N, 2)`` [m], counted from ``corner``."""
        col, row = np.floor(self._cells(xy, corner)).astype(np.intp).T
        return row, col

    def _window(self, points: np.ndarray, pose: np.ndarray) -> tuple[tuple[slice, slice], np.ndarray]:
        """Slices around ``points`` (N, 2) [m] and the robot, after growing the grid, and their corner (row, col)."""
        body = self.config.body_radius + 2 * self.resolution
        low = np.minimum(points.min(axis=0, initial=np.inf), pose[:2] - body)
        high = np.maximum(points.max(axis=0, initial=-np.inf), pose[:2] + body)
        first = np.floor(low[::-1] / self.resolution).astype(int) - 1
        last = np.floor(high[::-1] / self.resolution).astype(int) + 2
        self._grow(first, last)
        a, b = first - self._corner, last - self._corner
        return (slice(a[0], b[0]), slice(a[1], b[1])), first

    def _grow(self, first: np.ndarray, last: np.ndarray) -> None:
        """Makes the arrays hold cells ``first`` to ``last`` (exclusive), (row, col) from the map's origin."""
        chunk, shape = self.config.chunk, np.array(self._lidar.shape)
        before = -(-np.maximum(self._corner - first, 0) // chunk) * chunk
        after = -(-np.maximum(last - self._corner - shape, 0) // chunk) * chunk
        if not (before.any() or after.any()):
            return
        if (shape + before + after).max() * self.resolution > self.config.max_extent:
            raise ValueError(
                f"A measurement lies outside the {self.config.max_extent:g} m that a map may span; "
                "check the robot's pose, or raise max_extent."
            )
        pad = list(zip(before, after))
        self._lidar, self._depth, self._contact = (np.pad(x, pad) for x in (self._lidar, self._depth, self._contact))
        self._corner = self._corner - before


def _finite(pose: np.ndarray) -> np.ndarray:
    pose = np.asarray(pose, float)
    if pose.shape != (3,) or not np.isfinite(pose).all():
        raise ValueError(f"A pose needs three finite numbers x, y, theta; got {pose}.")
    return pose


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
