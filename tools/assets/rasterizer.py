"""Orthographic pictures of a mesh: a z-buffer with textures, Lambert shading and anti-aliasing by supersampling."""

from math import cos, sin
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit

from tools.assets.obj_model import Material, Mesh

SAMPLES = 3  # samples a pixel and axis; odd, so that one of them is the pixel's centre
MARGIN = 1.0  # px left free on each side when the picture is fitted to the model
AMBIENT, SKY, LAMP = 0.55, 0.15, 0.38  # light from everywhere, from above, from the lamp over the viewer's shoulder
SEE_THROUGH = 0.6  # glass is drawn at least this opaque: clearer glass leaves nothing to see in a small picture


class View(NamedTuple):
    """A rendered picture of size (h, w)."""

    rgba: np.ndarray  # (h, w, 4) uint8, colour not premultiplied
    depth: np.ndarray  # (h, w) float32 m behind the plane through the box's centre, along the view; NaN = nothing
    scale: float  # px per metre; the middle of the picture is the centre of the model's bounding box


def axes(yaw: float, pitch: float) -> np.ndarray:
    """Rows right, up, forward (3, 3) in the furniture frame, of a viewer in direction (yaw, pitch) [rad] of the model.

    ``yaw`` is the azimuth from the model to the viewer: -pi/2 sees the front, 0 the right-hand side (+x). A positive
    ``pitch`` looks down from above.
    """
    right = np.array([-sin(yaw), cos(yaw), 0.0])
    forward = -np.array([cos(yaw) * cos(pitch), sin(yaw) * cos(pitch), sin(pitch)])
    return np.stack([right, np.cross(right, forward), forward])


def extent(mesh: Mesh, yaw: float, pitch: float) -> tuple[float, float]:
    """Half width and half height [m] of the model's picture about the centre of its bounding box."""
    flat = np.abs((mesh.corners.reshape(-1, 3) - [0, 0, mesh.size[2] / 2]) @ axes(yaw, pitch)[:2].T).max(0)
    return float(flat[0]), float(flat[1])


def render(mesh: Mesh, yaw: float, pitch: float, size: int | tuple[int, int], scale: float | None = None) -> View:
    """Picture of ``mesh`` seen from (yaw, pitch) [rad] as `axes` defines them.

    ``size`` is the picture's side, or (width, height) [px]; ``scale`` is px per metre, by default the largest at which
    the whole model is inside.
    """
    width, height = (size, size) if isinstance(size, int) else size
    if scale is None:
        half_width, half_height = extent(mesh, yaw, pitch)
        scale = min((width / 2 - MARGIN) / max(half_width, 1e-6), (height / 2 - MARGIN) / max(half_height, 1e-6))
    frame = axes(yaw, pitch)
    local = (mesh.corners - np.array([0, 0, mesh.size[2] / 2], np.float32)) @ frame.T.astype(np.float32)
    fine = scale * SAMPLES
    x = local[..., 0] * fine + width * SAMPLES / 2 - 0.5
    y = -local[..., 1] * fine + height * SAMPLES / 2 - 0.5
    shade = _shade(mesh.normals, frame)
    colours = np.array([m.colour * 255 for m in mesh.materials], np.float32)
    opacity = np.array([1.0 if m.opacity >= 0.99 else max(m.opacity, SEE_THROUGH) for m in mesh.materials], np.float32)
    texels, table = _pyramids(mesh.materials)
    image, z = _draw(
        x.astype(np.float32), y.astype(np.float32), local[..., 2].astype(np.float32), shade, mesh.uv,
        mesh.material, colours, opacity, texels, table, width * SAMPLES, height * SAMPLES,
    )  # fmt: skip
    return View(*_reduce(image, z, width, height), scale)


def _shade(normals: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Brightness (T, 3) of the corners; both sides of a surface are lit, models are careless about orientation."""
    lamp = -frame[2] + 0.6 * frame[1] - 0.5 * frame[0]
    lamp /= np.linalg.norm(lamp)
    facing = np.where((normals @ -frame[2] < 0)[..., None], -normals, normals)
    return (AMBIENT + SKY * facing[..., 2] + LAMP * np.maximum(facing @ lamp, 0)).astype(np.float32)


def _pyramids(materials: list[Material]) -> tuple[np.ndarray, np.ndarray]:
    """All textures with their halvings in one array (K, 4), and where each starts: (M, 12, 3) offset, width, height."""
    table = np.zeros((len(materials), 12, 3), np.int64)
    flat, used, known = [np.zeros((1, 4), np.uint8)], 1, {}
    for number, material in enumerate(materials):
        if material.texture is None:
            continue
        if id(material.texture) not in known:
            known[id(material.texture)] = number
            level = material.texture
            for step in range(table.shape[1]):
                table[number, step] = used, level.shape[1], level.shape[0]
                flat.append(level.reshape(-1, 4))
                used += len(flat[-1])
                half = max(1, level.shape[1] // 2), max(1, level.shape[0] // 2)
                level = cv2.resize(level, half, interpolation=cv2.INTER_AREA)
        table[number] = table[known[id(material.texture)]]
    return np.concatenate(flat), table


def _reduce(image: np.ndarray, z: np.ndarray, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Average the samples of each pixel; its depth is the centre sample's, or else the nearest one's."""
    cells = (height, SAMPLES, width, SAMPLES)
    summed = image.reshape(*cells, 4).sum((1, 3))
    alpha = summed[..., 3:] / SAMPLES**2
    colour = summed[..., :3] / np.maximum(summed[..., 3:], 1e-6)
    rgba = np.concatenate([np.clip(colour, 0, 255), alpha * 255], 2).round().astype(np.uint8)
    samples = z.reshape(cells)
    middle = samples[:, SAMPLES // 2, :, SAMPLES // 2]
    depth = np.where(np.isfinite(middle), middle, samples.min((1, 3)))
    return rgba, np.where(np.isfinite(depth), depth, np.nan).astype(np.float32)


@njit(cache=True)
def _draw(x, y, z, shade, uv, material, colours, opacity, texels, table, width, height):
    """Samples: colour times opacity and opacity (height, width, 4) float32, and depth with inf = nothing."""
    image = np.zeros((height, width, 4), np.float32)
    depth = np.full((height, width), np.inf, np.float32)
    pane = np.full((height, width), np.inf, np.float32)  # nearest see-through surface in front of the solid one
    colour = np.zeros(3, np.float32)
    for solid in (True, False):
        for t in range(len(x)):
            m = material[t]
            if (opacity[m] >= 1.0) != solid:
                continue
            area = (x[t, 1] - x[t, 0]) * (y[t, 2] - y[t, 0]) - (x[t, 2] - x[t, 0]) * (y[t, 1] - y[t, 0])
            if abs(area) < 1e-9:
                continue
            level = 0
            if table[m, 0, 1] > 0:
                spread = (uv[t, 1, 0] - uv[t, 0, 0]) * (uv[t, 2, 1] - uv[t, 0, 1])
                spread -= (uv[t, 2, 0] - uv[t, 0, 0]) * (uv[t, 1, 1] - uv[t, 0, 1])
                texels_a_sample = abs(spread) * table[m, 0, 1] * table[m, 0, 2] / abs(area)
                while texels_a_sample > 2.0 and level < table.shape[1] - 1:
                    texels_a_sample *= 0.25
                    level += 1
            left = max(0, int(np.ceil(x[t].min())))
            right = min(width - 1, int(np.floor(x[t].max())))
            top = max(0, int(np.ceil(y[t].min())))
            bottom = min(height - 1, int(np.floor(y[t].max())))
            for j in range(top, bottom + 1):
                for i in range(left, right + 1):
                    b = ((i - x[t, 0]) * (y[t, 2] - y[t, 0]) - (x[t, 2] - x[t, 0]) * (j - y[t, 0])) / area
                    c = ((x[t, 1] - x[t, 0]) * (j - y[t, 0]) - (i - x[t, 0]) * (y[t, 1] - y[t, 0])) / area
                    a = 1.0 - b - c
                    if a < -1e-5 or b < -1e-5 or c < -1e-5:
                        continue
                    d = a * z[t, 0] + b * z[t, 1] + c * z[t, 2]
                    if d >= depth[j, i] or (not solid and d >= pane[j, i]):
                        continue
                    cover = opacity[m]
                    if table[m, 0, 1] > 0:
                        s = a * uv[t, 0, 0] + b * uv[t, 1, 0] + c * uv[t, 2, 0]
                        v = a * uv[t, 0, 1] + b * uv[t, 1, 1] + c * uv[t, 2, 1]
                        cover *= _sample(texels, table[m, level], s, v, colour)
                        if cover < 0.5:
                            continue
                    else:
                        colour[:] = colours[m]
                    light = a * shade[t, 0] + b * shade[t, 1] + c * shade[t, 2]
                    if solid:
                        depth[j, i] = d
                        image[j, i, 3] = 1.0
                        for k in range(3):
                            image[j, i, k] = min(255.0, colour[k] * light)
                    else:
                        pane[j, i] = d
                        for k in range(3):
                            image[j, i, k] = min(255.0, colour[k] * light) * cover + image[j, i, k] * (1 - cover)
                        image[j, i, 3] = cover + image[j, i, 3] * (1 - cover)
    for j in range(height):
        for i in range(width):
            depth[j, i] = min(depth[j, i], pane[j, i])  # a pane is drawn so opaque that it is what one sees
    return image, depth


@njit(cache=True)
def _sample(texels, place, s, v, colour):
    """Bilinear texture look-up, repeating; writes RGB to ``colour`` and returns the alpha in 0..1."""
    offset, width, height = place
    px = (s - np.floor(s)) * width - 0.5
    py = (1.0 - (v - np.floor(v))) * height - 0.5
    x0, y0 = int(np.floor(px)), int(np.floor(py))
    fx, fy = px - x0, py - y0
    alpha = 0.0
    colour[:] = 0.0
    for dy in range(2):
        for dx in range(2):
            weight = (fx if dx else 1 - fx) * (fy if dy else 1 - fy)
            row = offset + ((y0 + dy) % height) * width + (x0 + dx) % width
            for k in range(3):
                colour[k] += weight * texels[row, k]
            alpha += weight * texels[row, 3]
    return alpha / 255.0
