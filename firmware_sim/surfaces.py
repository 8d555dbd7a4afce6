"""Floor, walls and ceiling of a house as a level camera sees them: analytic depth, and colours from drawn textures."""

import cv2
import numpy as np

from edge.camera import CameraModel

FLOOR_PIXEL = 0.015  # m, of the drawn floor plan
FAR_PIXEL = 0.06  # m, of its smoothed copy for floor further away than FAR_FLOOR
FAR_FLOOR = 3.0  # m
WALL_PIXEL = 0.02  # m
WALL_TILE = 2.0  # m, length after which a wall's pattern repeats
SKIRTING = 0.08  # m, height of the board at the foot of a wall
TILED = 1.4  # m, height of the tiles on the walls of rooms with a tiled floor
SHADES = (0.82, 0.9, 0.96, 1.0)  # brightness of walls by the direction they face
CEILING = (238, 237, 233)
GROUND = (120, 118, 112)  # what lies outside all rooms
FAR = 60.0  # m, further than any wall
NUDGE = 0.12  # m before a wall, where the room is whose wall it is


class Surfaces:
    """The shell of one house, drawn once and looked at from any pose."""

    def __init__(self, house, model: CameraModel, seed: int = 0):
        """``house`` gives `rooms`, `wall_segments()` and `wall_height`; its walls must not change afterwards."""
        self.model = model
        self._segments = np.asarray(house.wall_segments(), float)
        self._rooms = list(house.rooms)
        rng = np.random.default_rng(seed)
        points = [np.asarray(room.polygon, float) for room in self._rooms] + [self._segments.reshape(-1, 2)]
        points = np.concatenate(points)
        self._corner = points.min(0) - 0.5
        shape = np.ceil((points.max(0) + 0.5 - self._corner) / FLOOR_PIXEL).astype(int)
        self._floor = np.full((shape[1], shape[0], 3), GROUND, np.uint8)
        self._room_at = np.full(shape[::-1], len(self._rooms), np.int16)
        for number, room in enumerate(self._rooms):
            corners = np.round((np.asarray(room.polygon, float) - self._corner) / FLOOR_PIXEL).astype(np.int32)
            (left, low), (right, high) = corners.min(0), corners.max(0) + 1
            part = np.s_[low:high, left:right]
            inside = np.zeros((high - low, right - left), np.uint8)
            inside = cv2.fillPoly(inside, [corners - (left, low)], 1).astype(bool)
            self._floor[part][inside] = floor_pattern(room.floor, inside.shape, rng)[inside]
            self._room_at[part][inside] = number
        factor = FLOOR_PIXEL / FAR_PIXEL
        self._far_floor = cv2.resize(self._floor, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        looks = [(tuple(room.wall_color), room.floor == "tiles") for room in self._rooms] + [(GROUND, False)]
        strips = [wall_pattern(*look, house.wall_height, rng) for look in looks]
        shaded = [np.clip(strip * shade, 0, 255).astype(np.uint8) for strip in strips for shade in SHADES]
        self._walls = np.hstack(shaded)  # a strip for each room and shade, one after the other
        along = self._segments[:, 1] - self._segments[:, 0]
        self._length = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
        facing = np.abs(along[:, 0]) / self._length * 2 + (along[:, 1] > 0)
        self._shade = np.clip(np.round(facing), 0, len(SHADES) - 1).astype(int)

        u0, v0 = model.centre
        self._slope = ((u0 - np.arange(model.width)) / model.focal).astype(np.float32)  # leftward, of each column
        self._rise = ((v0 - np.arange(model.height)) / model.focal).astype(np.float32)  # upward, of each row
        with np.errstate(divide="ignore"):
            above = np.where(self._rise > 0, house.wall_height - model.mount_height, model.mount_height)
            reach = above / np.abs(self._rise)
        self._level_depth = np.minimum(reach, FAR).astype(np.float32)  # of floor or ceiling in each row
        self._horizon = int(np.searchsorted(-self._rise, 0))  # first row that looks down
        ceiling = np.array(CEILING) * np.clip(1.04 - 0.035 * self._level_depth, 0.8, 1)[:, None]
        self._ceiling = np.repeat(ceiling[: self._horizon, None].astype(np.uint8), model.width, axis=1)

    def draw(self, x: float, y: float, heading: float) -> tuple[np.ndarray, np.ndarray]:
        """What a camera at (x, y) [m], ``heading`` [rad] sees of the shell.

        Returns rgb (H, W, 3) uint8 and depth (H, W) float32 m along the optical axis.
        """
        walls, strip = self._cast(x, y, heading)
        depth = np.minimum(self._level_depth[:, None], walls[None, :])
        row = (self.model.mount_height + self._rise[:, None] * walls[None, :]) * np.float32(-1 / WALL_PIXEL)
        row += np.float32(len(self._walls) - 0.5)
        column = np.broadcast_to(strip[None, :], row.shape)
        rgb = cv2.remap(self._walls, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        open_rows = self._level_depth[:, None] < walls[None, :]
        upper = self._horizon
        cv2.copyTo(self._ceiling, open_rows[:upper].view(np.uint8), rgb[:upper])
        floor = self._look_down(x, y, heading)
        cv2.copyTo(floor, open_rows[upper:].view(np.uint8), rgb[upper:])
        return rgb, depth

    def _cast(self, x: float, y: float, heading: float) -> tuple[np.ndarray, np.ndarray]:
        """Depth of the nearest wall in each column (W,), and the column of the wall texture seen there (W,)."""
        cos, sin = np.cos(heading), np.sin(heading)
        turn = np.array([[cos, -sin], [sin, cos]])
        ends = (self._segments - (x, y)) @ turn  # into the camera's frame, x forward
        ax, ay = ends[:, 0, 0], ends[:, 0, 1]
        bx, by = ends[:, 1, 0], ends[:, 1, 1]
        ahead = np.flatnonzero((ax > 1e-6) | (bx > 1e-6))
        ax, ay, bx, by = ax[ahead], ay[ahead], bx[ahead], by[ahead]
        # A ray (1, s) at depth t meets a + q (b - a) where q = (s ax - ay) / ((by - ay) - s (bx - ax)).
        slope = self._slope[:, None].astype(float)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (slope * ax - ay) / ((by - ay) - slope * (bx - ax))
            depth = ax + share * (bx - ax)
            depth[~((share >= 0) & (share <= 1) & (depth > 1e-3))] = FAR
        nearest = depth.argmin(1) if len(ahead) else np.zeros(len(slope), int)
        columns = np.arange(len(slope))
        if not len(ahead):
            return np.full(len(slope), FAR, np.float32), np.zeros(len(slope), np.float32)
        walls, share = depth[columns, nearest], share[columns, nearest]
        segment = ahead[nearest]
        place = np.where(walls < FAR, np.nan_to_num(share), 0) * self._length[segment]
        before = (walls - NUDGE)[:, None] * np.stack([np.ones(len(slope)), self._slope], 1) @ turn.T + (x, y)
        room = self._room(before)
        width = round(WALL_TILE / WALL_PIXEL)
        strip = (room * len(SHADES) + self._shade[segment]) * width
        strip = strip + np.minimum(place / WALL_PIXEL % width, width - 1)
        return walls.astype(np.float32), strip.astype(np.float32)

    def _room(self, points: np.ndarray) -> np.ndarray:
        """Number of the room at each point (N, 2); the number of rooms where there is none."""
        cells = ((points - self._corner) / FLOOR_PIXEL).astype(int)
        inside = ((cells >= 0) & (cells < self._room_at.shape[::-1])).all(1)
        cells = np.where(inside[:, None], cells, 0)
        return np.where(inside, self._room_at[cells[:, 1], cells[:, 0]], len(self._rooms))

    def _look_down(self, x: float, y: float, heading: float) -> np.ndarray:
        """The floor in all rows below the horizon (h, W, 3), by the homography of the floor plane."""
        model, upper = self.model, self._horizon
        u0, v0 = model.centre
        cos, sin = np.cos(heading), np.sin(heading)
        # Pixel (u, v) to the ray (f, u0 - u, v0 - v); it meets the floor after mount_height / (v - v0) times itself.
        ray = np.array([[0, 0, model.focal], [-1, 0, u0]])
        ground = np.array([[cos, -sin], [sin, cos]]) @ ray * model.mount_height
        lower = np.array([0, 1, -v0])
        split = max(upper, int(np.searchsorted(-self._level_depth[upper:], -FAR_FLOOR)) + upper)
        parts = []
        for start, stop, image, pixel in (
            (upper, split, self._far_floor, FAR_PIXEL),
            (split, model.height, self._floor, FLOOR_PIXEL),
        ):
            if stop <= start:
                continue
            offset = (np.array([x, y]) - self._corner)[:, None] * lower
            to_map = np.vstack([(ground + offset) / pixel - 0.5 * lower, lower])
            to_map = to_map @ np.array([[1, 0, 0], [0, 1, start], [0, 0, 1]])
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            size = (model.width, stop - start)
            parts.append(cv2.warpPerspective(image, to_map, size, flags=flags, borderValue=GROUND))
        return np.vstack(parts)


def floor_pattern(kind: str, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """A floor of ``kind`` (wood, tiles, carpet, stone) drawn at FLOOR_PIXEL, (rows, columns, 3) float 0..255."""
    rows, columns = (np.arange(count) for count in shape)
    if kind == "wood":  # planks of 12 cm, each with its own tone and joints
        plank, tone = rows // 8, rng.uniform(0.82, 1.08, shape[0] // 8 + 1)
        shift = rng.integers(0, 90, len(tone))
        board = (columns[None, :] + shift[plank][:, None]) // 90
        tones = tone[plank][:, None] * (1 + 0.06 * np.sin(board * 2.4 + plank[:, None]))
        grain = cv2.blur(rng.normal(0, 0.05, shape), (25, 1))
        joint = (rows % 8 == 0)[:, None] | ((columns[None, :] + shift[plank][:, None]) % 90 == 0)
        light = (tones + grain) * np.where(joint, 0.75, 1)
        colour = (176, 132, 88)
    elif kind == "tiles":  # 36 cm tiles with light joints
        tile = rng.uniform(0.93, 1.05, (shape[0] // 24 + 1, shape[1] // 24 + 1))
        light = tile[rows // 24][:, columns // 24]
        joint = (rows % 24 == 0)[:, None] | (columns % 24 == 0)[None, :]
        light = np.where(joint, 0.78, light)
        colour = (206, 204, 196)
    elif kind == "stone":  # grey slabs of 60 cm, mottled
        slab = rng.uniform(0.88, 1.08, (shape[0] // 40 + 1, shape[1] // 40 + 1))
        light = slab[rows // 40][:, columns // 40] + cv2.blur(rng.normal(0, 0.25, shape), (7, 7))
        joint = (rows % 40 == 0)[:, None] | (columns % 40 == 0)[None, :]
        light = np.where(joint, 0.7, light)
        colour = (150, 148, 144)
    else:  # carpet
        light = 1 + rng.normal(0, 0.06, shape) + cv2.blur(rng.normal(0, 0.4, shape), (41, 41))
        colour = (142, 138, 150)
    return np.clip(light[..., None] * np.array(colour), 0, 255)


def wall_pattern(colour, tiled: bool, height: float, rng: np.random.Generator) -> np.ndarray:
    """A strip of wall WALL_TILE long, (rows from the ceiling down, columns, 3) float: plaster, skirting, tiles."""
    shape = round(height / WALL_PIXEL), round(WALL_TILE / WALL_PIXEL)
    blotches = np.tile(rng.normal(0, 0.15, shape), 3)  # so that the strip joins itself without a seam
    blotches = cv2.blur(blotches, (15, 15))[:, shape[1] : 2 * shape[1]]
    light = 1 + rng.normal(0, 0.008, shape) + blotches
    light *= np.linspace(0.99, 0.93, shape[0])[:, None]
    strip = light[..., None] * np.array(colour, float)
    above_floor = (shape[0] - 0.5 - np.arange(shape[0])) * WALL_PIXEL
    if tiled:
        low = above_floor < TILED
        joint = (np.arange(shape[0]) % 10 == 0)[:, None] | (np.arange(shape[1]) % 10 == 0)
        strip[low] = (np.where(joint, 0.86, 1.0)[..., None] * light[..., None] * (232, 236, 236))[low]
    strip[above_floor < SKIRTING] = (214, 210, 203)
    return strip
