"""The RGB-D camera of the simulated robot: walls by ray casting, furniture by relief impostors, one depth buffer."""

from dataclasses import dataclass
from math import atan2, cos, hypot, sin

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.pose import compose, wrap
from firmware_sim.pedestrian import Figure
from firmware_sim.sprites import NEAREST, Window, cast
from firmware_sim.surfaces import Surfaces

EDGES = np.array([(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit])  # of a box, by corner number
CORNERS = np.array([[(i >> k & 1) - 0.5 for k in range(3)] for i in range(8)])


@dataclass(frozen=True)
class Picture:
    """One frame. All arrays are registered: the same pixel is the same ray."""

    rgb: np.ndarray  # (H, W, 3) uint8
    depth: np.ndarray  # (H, W) float32 m along the optical axis; 0 = no return
    instances: np.ndarray  # (H, W) int16 index into `Camera.object_ids`; -1 = walls, floor, ceiling, people


@dataclass(frozen=True)
class CameraNoise:
    """Noise of the pictures. The depth's is that of a stereo camera: a fixed disparity error grows with z squared."""

    disparity: float = 0.0012  # 1/m; depth noise is this times z^2: 3 cm at 5 m, 5 mm at 2 m (RealSense D435 class)
    bumps: float = 0.5  # share of it that is smooth over BUMP pixels, as stereo matching over windows makes it
    dropout: float = 0.004  # share of pixels without a return
    colour: float = 3.0  # grey levels, standard deviation


BUMP = 9  # px
MARGIN = 64  # px by which the drawn noise is larger than a picture, so that each frame cuts another piece of it


class Camera:
    """Renders what the robot's camera sees in a house. Things may be moved, added and removed between pictures."""

    def __init__(self, house, model: CameraModel | None = None, seed: int = 0, noise: bool | CameraNoise = True):
        """``noise``: True = as `CameraNoise` states, False = none. Pictures repeat from the same seed and sequence."""
        self.house = house
        self.model = model or CameraModel()
        self.noise = CameraNoise() if noise is True else noise or None
        self.object_ids: list[str] = list(house.objects)
        self._seed = seed
        u0, v0 = self.model.centre
        self._slopes = Window(
            ((u0 - np.arange(self.model.width)) / self.model.focal).astype(np.float32),
            ((v0 - np.arange(self.model.height)) / self.model.focal).astype(np.float32),
            self.model.focal,
        )
        self._shell: tuple | None = None  # the plan that the surfaces were drawn from, and these
        self._rng = np.random.default_rng(seed)
        if self.noise:
            self._draw_noise()

    @property
    def _surfaces(self) -> Surfaces:
        if self._shell is None or self._shell[0] is not self.house.plan:  # first picture, or a door was moved
            self._shell = self.house.plan, Surfaces(self.house, self.model, self._seed)
        return self._shell[1]

    def render(self, pose, figure: Figure | None = None) -> Picture:
        """The picture from base pose ``pose`` (3,) in the house frame, with a person in it if there is a ``figure``."""
        x, y, heading = compose(pose, (self.model.ahead, self.model.left, 0.0))
        rgb, depth = self._surfaces.draw(x, y, heading)
        instances = np.full(depth.shape, -1, np.int16)
        for thing, centre in self._in_view(x, y, heading):
            self._compose(thing, centre, heading, rgb, depth, instances)
        if figure is not None:
            figure.draw((x, y, heading), self.model, rgb, depth, instances)
        if self.noise:
            rgb, depth = self._disturb(rgb, depth)
        depth[(depth < self.model.min_depth) | (depth > self.model.max_depth)] = 0
        return Picture(rgb, depth, instances)

    def silhouette(self, pose, object_id: str) -> np.ndarray:
        """Pixels (H, W) bool that the object would fill if nothing hid it. Raises KeyError when it is unknown."""
        x, y, heading = compose(pose, (self.model.ahead, self.model.left, 0.0))
        mask = np.zeros((self.model.height, self.model.width), bool)
        thing = self.house.objects[object_id]
        centre = self._centre(thing, x, y, heading)
        rows, columns, _ = self._bounds(thing, centre, heading)
        if rows.stop > rows.start and columns.stop > columns.start:
            mask[rows, columns] = self._cast(thing, centre, heading, rows, columns)[1][..., 3] > 127
        return mask

    def _centre(self, thing, x: float, y: float, heading: float) -> np.ndarray:
        """Centre (3,) of the thing's bounding box in the camera's frame."""
        dx, dy = thing.x - x, thing.y - y
        c, s = cos(heading), sin(heading)
        up = thing.elevation + thing.model.size[2] / 2 - self.model.mount_height
        return np.array([c * dx + s * dy, c * dy - s * dx, up])

    def _in_view(self, x: float, y: float, heading: float) -> list:
        """Things that may be in the picture and their centres, nearest first."""
        spread = hypot(1.0, self._slopes.y[0])
        found = []
        for thing in self.house.objects.values():
            centre = self._centre(thing, x, y, heading)
            reach = hypot(thing.model.size[0], thing.model.size[1]) / 2
            ahead, aside = centre[0], abs(centre[1])
            if ahead > -reach and aside - self._slopes.y[0] * ahead < reach * spread:
                found.append((thing, centre))
        return sorted(found, key=lambda item: hypot(item[1][0], item[1][1]))

    def _bounds(self, thing, centre: np.ndarray, heading: float) -> tuple[slice, slice, float]:
        """Rows and columns that the thing's bounding box covers, and the least depth [m] of the box in front."""
        turn = thing.yaw - heading
        local = CORNERS * thing.model.size
        corners = np.empty((8, 3))
        corners[:, 0] = centre[0] + cos(turn) * local[:, 0] - sin(turn) * local[:, 1]
        corners[:, 1] = centre[1] + sin(turn) * local[:, 0] + cos(turn) * local[:, 1]
        corners[:, 2] = centre[2] + local[:, 2]
        front = corners[:, 0] > NEAREST
        if not front.any():
            return slice(0, 0), slice(0, 0), NEAREST
        if not front.all():  # keep what is before the camera: cut the edges that pass the near plane
            a, b = corners[EDGES[:, 0]], corners[EDGES[:, 1]]
            crossing = front[EDGES[:, 0]] != front[EDGES[:, 1]]
            a, b = a[crossing], b[crossing]
            cut = a + ((NEAREST - a[:, 0]) / (b[:, 0] - a[:, 0]))[:, None] * (b - a)
            corners = np.concatenate([corners[front], cut])
        u0, v0 = self.model.centre
        u = u0 - self.model.focal * corners[:, 1] / corners[:, 0]
        v = v0 - self.model.focal * corners[:, 2] / corners[:, 0]
        rows = slice(max(0, int(v.min())), min(self.model.height, int(v.max()) + 2))
        columns = slice(max(0, int(u.min())), min(self.model.width, int(u.max()) + 2))
        return rows, columns, float(corners[:, 0].min())

    def _cast(self, thing, centre, heading, rows: slice, columns: slice) -> tuple[np.ndarray, np.ndarray]:
        """Depth and premultiplied colour of the thing in a window of pixels."""
        azimuth = wrap(atan2(-centre[1], -centre[0]) + heading - thing.yaw)
        pitch = atan2(-centre[2], hypot(centre[0], centre[1]))
        sprite = thing.model.sprites.nearest(float(azimuth), pitch)
        window = Window(self._slopes.y[columns], self._slopes.z[rows], self._slopes.focal)
        return cast(sprite, window, centre, thing.yaw - heading)

    def _compose(self, thing, centre, heading, rgb, depth, instances) -> None:
        """Draw one thing into the picture where it is nearer than what is there."""
        rows, columns, near = self._bounds(thing, centre, heading)
        if rows.stop <= rows.start or columns.stop <= columns.start:
            return
        free = depth[rows, columns] > near
        rows, columns = _trim(rows, free.any(1)), _trim(columns, free.any(0))
        if rows.stop <= rows.start:
            return
        surface, rgba = self._cast(thing, centre, heading, rows, columns)
        behind = depth[rows, columns]
        alpha = rgba[..., 3]
        alpha[surface >= behind] = 0
        if thing.id not in self.object_ids:
            self.object_ids.append(thing.id)
        solid = alpha > 127
        np.copyto(behind, surface, where=solid)
        np.copyto(instances[rows, columns], np.int16(self.object_ids.index(thing.id)), where=solid)
        picture = rgb[rows, columns]
        whole = alpha == 255
        np.copyto(picture, rgba[..., :3], where=whole[..., None])
        j, i = np.nonzero((alpha > 0) & ~whole)
        if j.size:  # the soft edge
            rest = 255 - alpha[j, i].astype(np.uint16)[:, None]
            picture[j, i] = rgba[j, i, :3] + (picture[j, i] * rest + 127) // 255

    def _draw_noise(self) -> None:
        """Draw noise once, larger than a picture; drawing it anew for each frame would cost more than rendering."""
        shape = self.model.height + MARGIN, self.model.width + MARGIN
        fine = self._rng.normal(size=shape)
        smooth = cv2.GaussianBlur(self._rng.normal(size=shape), (0, 0), BUMP / 3)
        smooth /= smooth.std()
        mixed = fine * np.sqrt(1 - self.noise.bumps**2) + smooth * self.noise.bumps
        self._depth_noise = (mixed * self.noise.disparity).astype(np.float32)
        self._depth_noise[self._rng.random(shape) < self.noise.dropout] = -np.inf
        grain = self._rng.normal(0, self.noise.colour, (*shape, 3)).round()
        self._brighter = np.clip(grain, 0, 255).astype(np.uint8)
        self._darker = np.clip(-grain, 0, 255).astype(np.uint8)

    def _disturb(self, rgb: np.ndarray, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        j, i = self._rng.integers(0, MARGIN, 2)
        cut = np.s_[j : j + self.model.height, i : i + self.model.width]
        depth += self._depth_noise[cut] * depth * depth
        rgb = cv2.subtract(cv2.add(rgb, self._brighter[cut]), self._darker[cut])
        return rgb, depth


def _trim(window: slice, wanted: np.ndarray) -> slice:
    """The part of ``window`` from the first to the last index that is ``wanted``; empty when there is none."""
    found = np.flatnonzero(wanted)
    return slice(window.start + int(found[0]), window.start + int(found[-1]) + 1) if found.size else slice(0, 0)
