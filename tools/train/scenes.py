"""Composite training pictures: cut-out models at metric scale in made-up rooms, with the truth of what is where."""

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np

from edge.camera import CameraModel
from tools.assets.catalog import Entry
from tools.train.sprites import Sprite
from tools.train.words import noun

CAMERA = CameraModel()
ENLARGED = 0.45  # share of the views that are a part of a picture, as when the robot looks more closely
RECOLOURED = 0.4  # share of the things that get another colour
CELLS = (14, 18)  # rows, columns of the presence map: the detail map's own cells


@dataclass(frozen=True)
class Scene:
    """One picture.

    ``rgb`` (240, 320, 3) uint8; ``models`` (K,) index into the entries; ``presence`` (K, 14, 18) float32: share of each
    cell's pixels that show the model; ``visible`` (K,) share of the model's own pixels left in view.
    """

    rgb: np.ndarray
    models: np.ndarray
    presence: np.ndarray
    visible: np.ndarray


class SceneMaker:
    """Draws scenes from a set of models. ``sprites[i]`` are the cut-outs of ``entries[i]``."""

    def __init__(self, entries: list[Entry], sprites: list[list[Sprite]], seed: int):
        self._entries, self._sprites = entries, sprites
        self._rng = np.random.default_rng(seed)
        self._shares = _shares(entries)

    def close_up(self, model: int) -> Scene:
        """One model that fills most of the picture, on a plain or a furnished background."""
        rng = self._rng
        background = two_tone(rng) if rng.random() < 0.4 else room(rng)
        sprite = self._sprites[model][rng.integers(len(self._sprites[model]))]
        height, width = sprite.rgba.shape[:2]
        zoom = rng.uniform(0.55, 1.0) * min(CAMERA.height / height, CAMERA.width / width)
        left = rng.uniform(0, CAMERA.width - width * zoom)
        top = rng.uniform(0.2, 1.0) * (CAMERA.height - height * zoom)
        return self._compose(background, [(model, sprite, zoom, left, top)])

    def view(self, count: int) -> Scene:
        """``count`` models at 0.7 to 4.5 m as the robot's camera sees them, the nearer in front of the farther."""
        rng = self._rng
        placed = []
        for depth in sorted(rng.uniform(0.7, 4.5, count), reverse=True):
            model = int(rng.choice(len(self._entries), p=self._shares))
            entry = self._entries[model]
            sprite = self._sprites[model][rng.integers(len(self._sprites[model]))]
            size = max(entry.size)
            # Models beyond furniture size (a bus, a tree) shrink to it, tiny ones come near: both should be seen.
            shrink = min(size, 2.2) / size
            depth = min(depth, max(1.0, 9.0 * size))
            zoom = CAMERA.focal / depth / sprite.scale * shrink
            height, width = sprite.rgba.shape[0] * zoom, sprite.rgba.shape[1] * zoom
            base = entry.elevation or 0.0
            if size < 0.6 and not base:
                base = rng.choice([0.0, 0.45, 0.75])  # on the floor, on a seat, on a table
            horizon = CAMERA.centre[1]
            bottom = horizon + CAMERA.focal * (CAMERA.mount_height - base) / depth
            centre = rng.uniform(0.02, 0.98) * CAMERA.width
            placed.append((model, sprite, zoom, centre - width / 2, bottom - height))
        return self._compose(room(rng), placed, enlarge=rng.random() < ENLARGED)

    def empty(self) -> Scene:
        """A room without anything in it."""
        return self._compose(room(self._rng), [])

    def _compose(self, image: np.ndarray, placed: list, enlarge: bool = False) -> Scene:
        """``placed``: (model, sprite, zoom, left, top) from far to near; ``enlarge`` keeps a window of the picture."""
        rng = self._rng
        owner = np.full(image.shape[:2], -1, np.int16)
        own = np.zeros(len(placed))
        for number, (_, sprite, zoom, left, top) in enumerate(placed):
            rgba, shift = _place(sprite.rgba, zoom, left, top, rng.random() < 0.5)
            own[number] = max(1.0, (sprite.rgba[..., 3] > 128).sum() * zoom**2)
            if rgba is None:
                continue
            x, y = shift
            alpha = rgba[..., 3:].astype(np.float32) / 255
            tint = _tint(rng)
            part = np.s_[y : y + rgba.shape[0], x : x + rgba.shape[1]]
            image[part] = image[part] * (1 - alpha) + np.clip(rgba[..., :3] @ tint, 0, 255) * alpha
            owner[part][rgba[..., 3] > 128] = number
        rgb = _shoot(image, rng)
        if enlarge:
            window = _around(rng, owner) if rng.random() < 0.5 else _window(rng)
            rgb = cv2.resize(rgb[window], (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_LINEAR)
            own *= owner.size / owner[window].size
            owner = cv2.resize(owner[window], (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_NEAREST)
        presence = np.zeros((len(placed), *CELLS), np.float32)
        visible = np.zeros(len(placed), np.float32)
        for number in range(len(placed)):
            mask = (owner == number).astype(np.float32)
            presence[number] = cv2.resize(mask, CELLS[::-1], interpolation=cv2.INTER_AREA)
            visible[number] = mask.sum() / own[number]
        models = np.array([model for model, *_ in placed], np.int64)
        return Scene(rgb, models, presence, visible)


def _tint(rng: np.random.Generator) -> np.ndarray:
    """Matrix (3, 3) for rows of RGB: other light, and for some things another hue and saturation, as furniture comes
    in any colour."""
    tint = np.diag(rng.uniform(0.75, 1.2) * rng.uniform(0.94, 1.06, 3)).astype(np.float32)
    if rng.random() < RECOLOURED:
        grey = np.full((3, 3), 1 / 3)
        turn = np.array([[0, -1, 1], [1, 0, -1], [-1, 1, 0]]) / np.sqrt(3)  # about the grey axis
        angle, saturation = rng.normal(0, 1.0), rng.uniform(0.2, 1.4)
        tint = (grey + saturation * (np.cos(angle) * (np.eye(3) - grey) + np.sin(angle) * turn)).T @ tint
    return tint.astype(np.float32)


def _shares(entries: list[Entry]) -> np.ndarray:
    """How often each model is drawn: names with many models less often each; wall sockets and road signs rarely."""
    count = Counter(noun(entry) for entry in entries)
    shares = np.array([count[noun(entry)] ** -0.5 for entry in entries])
    shares[[bool({"Electricity", "Road"} & set(entry.tags)) for entry in entries]] *= 0.15
    return shares / shares.sum()


def _window(rng: np.random.Generator) -> tuple[slice, slice]:
    """Rows and columns of a part of about half the width and 5/8 of the height, mostly low: where furniture is."""
    share = rng.uniform(0.45, 0.6)
    width, height = round(share * CAMERA.width), round(1.25 * share * CAMERA.height)
    left = int(rng.integers(CAMERA.width - width + 1))
    top = int((CAMERA.height - height) * rng.beta(2.5, 1.0))
    return slice(top, top + height), slice(left, left + width)


def _around(rng: np.random.Generator, owner: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns around one of the objects in view, with some of what is beside it: where a robot looks at."""
    shown = np.flatnonzero(np.bincount(owner[owner >= 0], minlength=1) > 30)
    if not len(shown):
        return _window(rng)
    rows, cols = np.nonzero(owner == rng.choice(shown))
    margin = rng.uniform(1.1, 2.2)
    height = max(np.ptp(rows) + 1, 0.75 * (np.ptp(cols) + 1), 24) * margin
    height = int(min(height, CAMERA.height))
    width = height * CAMERA.width // CAMERA.height
    shift = rng.uniform(-0.15, 0.15, 2) * height
    top = int(np.clip((rows.min() + rows.max() - height) / 2 + shift[0], 0, CAMERA.height - height))
    left = int(np.clip((cols.min() + cols.max() - width) / 2 + shift[1], 0, CAMERA.width - width))
    return slice(top, top + height), slice(left, left + width)


def _place(rgba: np.ndarray, zoom: float, left: float, top: float, mirror: bool):
    """The cut-out resized and cut at the picture's edges, and where it goes; (None, None) when nothing is left."""
    width, height = (max(1, round(side * zoom)) for side in rgba.shape[1::-1])
    if max(width, height) > 1500:
        return None, None
    rgba = cv2.resize(rgba, (width, height), interpolation=cv2.INTER_AREA if zoom < 1 else cv2.INTER_LINEAR)
    if mirror:
        rgba = rgba[:, ::-1]
    left, top = round(left), round(top)
    rgba = rgba[max(0, -top) : max(0, CAMERA.height - top), max(0, -left) : max(0, CAMERA.width - left)]
    return (rgba, (max(0, left), max(0, top))) if rgba.size else (None, None)


def two_tone(rng: np.random.Generator) -> np.ndarray:
    """A plain wall over a plain floor, (240, 320, 3) float32 RGB."""
    image = np.empty((CAMERA.height, CAMERA.width, 3), np.float32)
    horizon = int(rng.uniform(0.35, 0.8) * CAMERA.height)
    image[:horizon], image[horizon:] = _paint(rng), _paint(rng)
    return image


def room(rng: np.random.Generator) -> np.ndarray:
    """A wall or a corner over a floor with texture and light, sometimes a skirting board, (240, 320, 3) float32 RGB."""
    height, width = CAMERA.height, CAMERA.width
    u = (np.arange(width) - CAMERA.centre[0]) / CAMERA.focal
    v = (np.arange(height) - CAMERA.centre[1])[:, None] / CAMERA.focal
    distance = rng.uniform(0.5, 6.0) / np.maximum(0.2, 1 + rng.uniform(-0.9, 0.9) * u)
    if rng.random() < 0.6:  # a corner: the nearer of two walls
        distance = np.minimum(distance, rng.uniform(1.5, 6.0) / np.maximum(0.2, 1 + rng.uniform(-1.8, 1.8) * u))
    drop = CAMERA.mount_height / np.maximum(v, 1e-3)  # m to where the ray meets the floor
    floor = drop < distance[None]
    shade = 1 - 0.06 * np.minimum(distance, 5)
    image = np.where(floor[..., None], 0, (_paint(rng) * shade[:, None])[None]).astype(np.float32)
    if rng.random() < 0.25:
        image = np.where(floor[..., None], 0, image * _tiles(rng, v * distance[None], (u * distance)[None])[..., None])
    if rng.random() < 0.35:
        _open_doorway(rng, image, floor)
    image[floor] = _floor(rng, np.where(floor, drop, 0)[floor], np.broadcast_to(u, floor.shape)[floor])
    above = (CAMERA.mount_height - v * distance[None]) > 2.5
    image[above & ~floor] = rng.uniform(200, 250)
    if rng.random() < 0.5:
        board = ~floor & (CAMERA.mount_height - v * distance[None] < 0.08)
        image[board] = rng.uniform(120, 250)
    glow = 1 + rng.uniform(-0.2, 0.2) * np.linspace(-1, 1, width)[None] + rng.uniform(-0.15, 0.15) * v
    return image * glow[..., None].astype(np.float32)


def _tiles(rng: np.random.Generator, height: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Brightness of a tiled wall at points given in metres, dark or pale joints."""
    side, joint = rng.uniform(0.1, 0.4), rng.uniform(0.005, 0.015)
    joints = (np.mod(height, side) < joint) | (np.mod(across, side) < joint)
    return np.where(joints, rng.uniform(0.4, 1.1), 1.0)


def _open_doorway(rng: np.random.Generator, image: np.ndarray, floor: np.ndarray) -> None:
    """Another room behind a gap in the wall: a strip of other walls, down to the floor."""
    left = int(rng.uniform(-0.1, 0.9) * image.shape[1])
    right = left + int(rng.uniform(0.05, 0.35) * image.shape[1])
    gap = np.zeros_like(floor)
    gap[max(0, int(rng.uniform(-0.2, 0.3) * image.shape[0])) :, max(0, left) : right] = True
    image[gap & ~floor] = _paint(rng)
    inner = max(0, left) + int(rng.uniform(0.2, 0.8) * (right - max(0, left)))
    gap[:, :inner] = False
    image[gap & ~floor] = _paint(rng)


def _floor(rng: np.random.Generator, depth: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Colours (N, 3) of floor points ``depth`` m ahead and ``u * depth`` m aside: tiles, planks, carpet or plain."""
    base = _paint(rng, 0.8)
    turn = rng.uniform(0, np.pi)
    x = depth * np.cos(turn) + u * depth * np.sin(turn)
    y = u * depth * np.cos(turn) - depth * np.sin(turn)
    kind = rng.integers(4)
    light = np.ones_like(depth)
    if kind == 0:
        side = rng.uniform(0.2, 0.6)
        joint = (np.mod(x, side) < 0.015) | (np.mod(y, side) < 0.015)
        light = np.where(joint, rng.uniform(0.6, 0.9), 1.0)
    elif kind == 1:
        row = np.floor(y / rng.uniform(0.08, 0.2))
        light = 0.85 + 0.15 * np.mod(np.sin(row * 12.9898) * 43758.5453, 1.0)
    elif kind == 2:
        light = 1 + rng.normal(0, 0.08, depth.shape)
    else:
        side = rng.uniform(0.2, 0.5)
        light = np.where((np.floor(x / side) + np.floor(y / side)) % 2 > 0, 1.0, rng.uniform(0.6, 1.0))
    return base * light[:, None] * (1 - 0.03 * np.minimum(depth, 6))[:, None]


def _paint(rng: np.random.Generator, brightness: float = 1.0) -> np.ndarray:
    """A wall or floor colour (3,) in 0..255: mostly pale and little saturated."""
    grey = brightness * rng.uniform(90, 250)
    return np.clip(grey * (1 + rng.uniform(0.02, 0.25) * rng.normal(0, 1, 3)), 10, 255)


def _shoot(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Exposure, white balance, blur and noise of a cheap camera; uint8."""
    image = image * (rng.uniform(0.7, 1.2) * rng.uniform(0.95, 1.05, 3))
    if rng.random() < 0.4:
        image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.4, 1.2))
    image = image + rng.normal(0, rng.uniform(1, 7), image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)
