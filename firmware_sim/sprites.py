"""Relief impostors: pictures of a thing from many directions, warped so that their perspective is right up close.

Each sprite is an orthographic picture with its relief, the depth behind the plane through the centre of the thing's
bounding box. A camera ray meets the thing where the depth along the ray equals the relief there; a few fixed-point
steps find that place (relief texture mapping, Oliveira et al. 2000; iterative parallax mapping, Premecz 2006).
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import cos, log2, pi, radians, sin
from pathlib import Path

import cv2
import numpy as np

WANDER = 3.0  # px a ray may move across the sprite before the first guess is searched for
MAX_LAYERS = 24  # of that search
COARSER = (4000, 16000)  # px; in windows larger than these only each second, then third ray and row is searched
NOTHING = 1e3  # m, relief where there is no surface
SETTLED = 0.06  # m, further than this from the relief, a ray has met no surface
GRAZING = 0.2  # smallest cosine between a ray and the sprite's view; beyond it the relief says nothing
NEAREST = 0.05  # m, depth at which a surface is cut off
SHEETS = 48  # decoded sheets kept in memory, about 5 MB each: the things of one home
SPRITES = 300  # sprites kept in memory, about 250 kB each


@dataclass(frozen=True, eq=False)
class Sprite:
    """A thing as seen from one direction."""

    yaw: float  # rad, azimuth from the thing to the viewer in the model frame
    pitch: float  # rad, positive looks down
    scale: float  # px per metre
    levels: tuple[np.ndarray, ...]  # (h, w, 4) uint8 RGBA premultiplied, then halved again and again
    relief: np.ndarray  # (h, w) float32 m behind the plane through the centre, continued outside the silhouette
    solid_relief: np.ndarray  # (h, w) float32 the same, NOTHING outside the silhouette
    start: float  # m, its median
    span: tuple[float, float]  # m, its least and largest value


@dataclass(frozen=True)
class Window:
    """Rays of a rectangle of pixels, in the camera's frame: x forward, y left, z up."""

    y: np.ndarray  # (w,) float32, leftward slope of each column's rays
    z: np.ndarray  # (h,) float32, upward slope of each row's rays
    focal: float  # px


class SpriteSheet:
    """The pictures of one model: a row for each pitch, a column for each yaw."""

    def __init__(self, colour: Path, relief: Path, layout: dict):
        """``layout`` is what the catalog says of the sheets; tools/assets/sprite_sheet.py writes it."""
        self._paths = colour, relief
        self.width, self.height = layout["cell"]  # px
        self.scale = layout["scale"]  # px per metre
        self.yaws = layout["yaws"]  # columns: the first looks from azimuth -pi, the next ones counter-clockwise
        self.pitches = tuple(radians(pitch) for pitch in layout["pitches"])
        self.relief_range = tuple(layout["relief"])  # m at grey 0 and 255

    def nearest(self, azimuth: float, pitch: float) -> Sprite:
        """The sprite whose direction from the thing to the viewer is nearest to (azimuth, pitch) [rad]."""
        column = round((azimuth + pi) / (2 * pi) * self.yaws) % self.yaws
        row = min(range(len(self.pitches)), key=lambda i: abs(self.pitches[i] - pitch))
        return _cut(self, row, column)

    def decode(self) -> tuple[np.ndarray, np.ndarray]:
        """Colour (H, W, 4) uint8 RGBA and relief (H/2, W/2) uint8. Raises ValueError when a file is damaged."""
        decoded = []
        shape = len(self.pitches) * self.height, self.yaws * self.width
        for path, flag, divisor in zip(self._paths, (cv2.IMREAD_UNCHANGED, cv2.IMREAD_GRAYSCALE), (1, 2)):
            image = cv2.imread(str(path), flag)
            if image is None or image.shape[:2] != (shape[0] // divisor, shape[1] // divisor):
                raise ValueError(f"The sprite sheet {path} is missing or damaged; `python -m tools.assets.furniture`.")
            decoded.append(image)
        colour, relief = decoded
        code = cv2.COLOR_BGRA2RGBA if colour.shape[2] == 4 else cv2.COLOR_BGR2RGBA  # a model that fills every cell
        return cv2.cvtColor(colour, code), relief


@lru_cache(SHEETS)
def _decoded(sheet: SpriteSheet) -> tuple[np.ndarray, np.ndarray]:
    return sheet.decode()


@lru_cache(SPRITES)
def _cut(sheet: SpriteSheet, row: int, column: int) -> Sprite:
    colour, relief = _decoded(sheet)
    width, height = sheet.width, sheet.height
    rgba = colour[row * height : (row + 1) * height, column * width : (column + 1) * width].copy()
    rgba[..., :3] = (rgba[..., :3].astype(np.uint16) * rgba[..., 3:] + 127) // 255
    levels = [rgba]
    while min(levels[-1].shape[:2]) > 8:
        half = (levels[-1].shape[1] + 1) // 2, (levels[-1].shape[0] + 1) // 2
        levels.append(cv2.resize(levels[-1], half, interpolation=cv2.INTER_AREA))
    grey = relief[row * height // 2 : (row + 1) * height // 2, column * width // 2 : (column + 1) * width // 2]
    near, far = sheet.relief_range
    # The sheet's pixel k is the colour's pixel 2k + 1.
    twice = np.array([[2, 0, 1], [0, 2, 1]], float)
    grey = cv2.warpAffine(grey.astype(np.float32), twice, (width, height), borderMode=cv2.BORDER_REPLICATE)
    metres = near + grey * np.float32((far - near) / 255)
    covered = rgba[..., 3] > 127
    solid = metres[covered] if covered.any() else np.zeros(1, np.float32)
    yaw = 2 * pi * column / sheet.yaws - pi
    return Sprite(
        yaw, sheet.pitches[row], sheet.scale, tuple(levels), metres, np.where(covered, metres, np.float32(NOTHING)),
        float(np.median(solid)), (float(solid.min()), float(solid.max())),
    )  # fmt: skip


def cast(sprite: Sprite, window: Window, centre: np.ndarray, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """Where the rays of ``window`` (h rows, w columns) meet the thing.

    ``centre`` (3,) [m] is the centre of the thing's bounding box and ``yaw`` [rad] its heading, in the camera's frame.
    Returns the depth (h, w) float32 [m] along the optical axis and the colour (h, w, 4) uint8, premultiplied RGBA;
    where alpha is 0 the ray misses and the depth means nothing.
    """
    facing, c, s = sprite.yaw + yaw, cos(sprite.pitch), sin(sprite.pitch)
    right = np.array([-sin(facing), cos(facing), 0.0])
    forward = np.array([-cos(facing) * c, -sin(facing) * c, -s])
    up = np.array([-cos(facing) * s, -sin(facing) * s, c])  # right x forward
    y, z = window.y[None, :], window.z[:, None]

    # A point at depth t on a ray (1, y, z) lies at t * (1, y, z) . axis - centre . axis along each axis of the sprite,
    # so that one with relief w has the depth (w + centre . forward) / (1, y, z) . forward.
    away = np.float32(forward[0]) + np.float32(forward[1]) * y + np.float32(forward[2]) * z
    steepness = 1 / np.maximum(away, GRAZING)
    across = (np.float32(right[0]) + np.float32(right[1]) * y) * steepness
    upward = (np.float32(up[0]) + np.float32(up[1]) * y + np.float32(up[2]) * z) * steepness
    picture = sprite.levels[0]
    rays = _Rays(
        across * np.float32(sprite.scale),
        upward * np.float32(-sprite.scale),
        (picture.shape[1] - 1) / 2 - sprite.scale * (right @ centre),
        (picture.shape[0] - 1) / 2 + sprite.scale * (up @ centre),
        forward @ centre,
    )
    relief, lost = _search(sprite, rays)
    column, row = rays.at(relief)
    depth = relief + np.float32(rays.distance)
    depth *= steepness
    shrink = sprite.scale * max(rays.distance, NEAREST) / window.focal  # sprite pixels a picture pixel
    level = min(max(0, round(log2(shrink))), len(sprite.levels) - 1)
    if level:
        picture = sprite.levels[level]
        factor = np.float32(2.0**-level)
        column, row = ((index + np.float32(0.5)) * factor - np.float32(0.5) for index in (column, row))
    rgba = cv2.remap(picture, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=(0, 0, 0, 0))
    lost |= depth < NEAREST
    lost |= away < GRAZING
    rgba[lost] = 0
    return depth, rgba


@dataclass(frozen=True)
class _Rays:
    """Rays as lines across a sprite: the pixel where each is, as a function of its relief."""

    across: np.ndarray  # (h, w) float32 columns a metre
    down: np.ndarray  # (h, w) float32 rows a metre
    column: float  # px, of the rays' common origin
    row: float
    distance: float  # m from that origin to the plane of relief 0

    def at(self, relief) -> tuple[np.ndarray, np.ndarray]:
        """Columns and rows (h, w) [px] at ``relief`` [m], an array (h, w) or a number."""
        ahead = relief + np.float32(self.distance)
        column, row = self.across * ahead, self.down * ahead
        column += np.float32(self.column)
        row += np.float32(self.row)
        return column, row

    def thinned(self, step: int) -> "_Rays":
        return replace(self, across=self.across[::step, ::step], down=self.down[::step, ::step])


def _search(sprite: Sprite, rays: _Rays) -> tuple[np.ndarray, np.ndarray]:
    """Relief (h, w) [m] at which each ray meets the sprite's surface, and (h, w) bool where it meets none."""

    def surface(relief):
        return cv2.remap(sprite.relief, *rays.at(relief), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    near, far = sprite.span
    # Over the sprite's relief a ray wanders this far across the picture: the farther, the more there is to search.
    wander = (far - near) * float(max(np.abs(rays.across).max(), np.abs(rays.down).max()))
    if wander < WANDER:
        relief = surface(np.float32(sprite.start))
        return (surface(relief) if wander > 1 else relief), np.zeros(relief.shape, bool)
    layers = min(int(wander / WANDER) + 1, MAX_LAYERS)
    height, width = rays.across.shape
    thin = 1 + sum(height * width > size for size in COARSER)
    coarse = _first_hit(sprite, rays.thinned(thin), layers)
    guess, hit, gap = (np.repeat(np.repeat(a, thin, 0), thin, 1)[:height, :width] for a in coarse)
    # A step of the fixed point, then one of the secant through both.
    reach = np.float32((far - near) / layers)
    miss = surface(guess) - guess
    second = guess + np.clip(miss, -reach, reach)
    second_miss = surface(second) - second
    change = second_miss - miss
    change[np.abs(change) < 1e-6] = 1e-6
    relief = second - np.clip(second_miss * (second - guess) / change, -reach, reach)
    missed = np.abs(surface(relief) - relief) > SETTLED
    np.copyto(relief, guess, where=gap | (missed & hit))
    return relief, missed & ~hit


def _first_hit(sprite: Sprite, rays: _Rays, layers: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Relief (h, w) [m] where each ray, followed in layers from the front, first passes a surface, and two masks.

    The masks (h, w) tell where a surface was passed at all, and where a ray came from before a far surface to behind a
    near one: it looks into the gap between the two, of which the sprite shows nothing, and is given the near end of
    the far surface.
    """
    near, far = sprite.span
    levels = np.linspace(near, far, layers + 1, dtype=np.float32)
    step = levels[1] - levels[0]
    height, width = rays.across.shape
    places = (place.reshape(-1, width) for place in rays.at(levels[:, None, None]))  # of all layers at once
    ahead = cv2.remap(
        sprite.solid_relief, *places, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=(NOTHING,)
    ).reshape(-1, height, width)
    ahead -= levels[:, None, None]  # from the layer to the surface there; positive = not reached
    passed = (ahead <= 0) & (ahead > -1.5 * step)
    crossed = np.zeros_like(passed)
    crossed[1:] = (ahead[1:] <= 0) & (ahead[:-1] > 0) & (ahead[:-1] < NOTHING / 2)
    event = passed | crossed
    first = event.argmax(0)[None]
    hit, passed, crossed, here = (np.take_along_axis(a, first, 0)[0] for a in (event, passed, crossed, ahead))
    before = np.take_along_axis(ahead, np.maximum(first - 1, 0), 0)[0]
    level = levels[first[0]]
    found = np.where(hit, level + here, np.float32(sprite.start))
    share = before / np.maximum(before - here, 1e-6)
    np.copyto(found, level - step + share * step, where=passed & crossed)
    gap = crossed & ~passed
    np.copyto(found, level - step, where=gap)
    # Beside a ray that hits, one that does not may stand for others, left out of the search, that do.
    beside = cv2.erode(np.where(hit, found, np.float32(NOTHING)), np.ones((3, 3), np.uint8))
    np.copyto(found, beside, where=~hit & (beside < NOTHING / 2))
    return found, hit, gap
