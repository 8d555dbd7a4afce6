"""What physics and lidar need to know of a mesh: its footprint, its outline at lidar height, the surface on its top."""

import cv2
import numpy as np

from tools.assets.obj_model import Mesh
from tools.assets.rasterizer import render

BODY_HEIGHT = 1.0  # m, the robot's: what is higher does not touch it
LIDAR_HEIGHT = 0.25  # m
MAX_SEGMENTS = 48  # of an outline; a lidar beam is tested against each of them
TOLERANCE = 0.01  # m, simplification of footprints and outlines
MIN_TOP_AREA = 0.04  # m2, a plate
MIN_TOP_SIDE = 0.15  # m, of the model; nothing stands on a rail
MIN_TOP = 0.03  # m; lower is the floor of a box or the plate of a hob
MIN_TOP_SHARE = 0.35  # of the bounding box; less is an edge or a rail, not a surface


def footprint(mesh: Mesh, height: float = BODY_HEIGHT) -> np.ndarray:
    """Convex hull (N, 2) [m], counter-clockwise, of the part of the mesh below ``height`` above its base."""
    corners = mesh.corners.astype(float)
    low = corners[corners[..., 2] <= height][:, :2]
    points = np.concatenate([low, _crossings(corners, height).reshape(-1, 2)]).astype(np.float32)
    hull = cv2.convexHull(points).reshape(-1, 2)
    simple = cv2.approxPolyDP(hull.reshape(-1, 1, 2), TOLERANCE / 2, True).reshape(-1, 2)
    hull = simple if len(simple) >= 3 else hull
    x, y = hull.T
    area = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    return (hull if area > 0 else hull[::-1]).astype(float)


def outline(mesh: Mesh, height: float = LIDAR_HEIGHT) -> np.ndarray:
    """Outer outlines (M, 2, 2) [m] of the mesh cut at ``height`` above its base, M <= MAX_SEGMENTS; M = 0 if not cut.

    The cut is drawn into a fine bitmap and its outer contours are followed, so that neither the insides nor the tiny
    triangles of the mesh matter. Parts too many to keep are merged with their neighbours.
    """
    cuts = _crossings(mesh.corners.astype(float), height)
    if not len(cuts):
        return np.zeros((0, 2, 2))
    low, high = cuts.reshape(-1, 2).min(0), cuts.reshape(-1, 2).max(0)
    pixel = max(0.004, float((high - low).max()) / 1000)
    border = 40
    shape = np.ceil((high - low) / pixel).astype(int) + 2 * border + 1
    bitmap = np.zeros((shape[1], shape[0]), np.uint8)
    cv2.polylines(bitmap, list(np.round((cuts - low) / pixel + border).astype(np.int32)), False, 255)
    for reach in (0, 2, 4, 8, 16, 32):
        merged = cv2.morphologyEx(bitmap, cv2.MORPH_CLOSE, np.ones((2 * reach + 1,) * 2, np.uint8))
        contours, _ = cv2.findContours(merged, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        loops = [cv2.approxPolyDP(c, TOLERANCE / 2 / pixel * (1 + reach / 4), True).reshape(-1, 2) for c in contours]
        loops = [loop for loop in loops if len(loop) > 1]
        if sum(map(len, loops)) <= MAX_SEGMENTS:
            break
    else:
        loops = [cv2.convexHull(np.concatenate(loops)).reshape(-1, 2)]
    segments = [np.stack([loop, np.roll(loop, -1, 0)], 1) for loop in loops]
    found = np.concatenate(segments)[:MAX_SEGMENTS] if segments else np.zeros((0, 2, 2))
    return (found - border) * pixel + low


def top(mesh: Mesh, stated: float | None) -> float | None:
    """Height [m] of the surface that things can stand on, or None.

    ``stated`` is the catalog's (None = not stated, negative = nothing can stand on it). It counts only where the model,
    seen from above, has enough level area at that height; else the most common height does, under the same condition.
    """
    width, depth, height = mesh.size
    if (stated is not None and stated < 0) or min(width, depth) < MIN_TOP_SIDE:
        return None
    view = render(mesh, -np.pi / 2, np.pi / 2, 96)
    heights = height / 2 - view.depth[np.isfinite(view.depth)]
    count, edges = np.histogram(heights, np.arange(-0.005, height + 0.02, 0.01))
    common = float(edges[count.argmax()] + 0.005)
    for level in (stated, height, common):
        if level is None or level < MIN_TOP:
            continue
        at = heights[np.abs(heights - level) < 0.02]
        area = len(at) / view.scale**2
        if area >= MIN_TOP_AREA and area >= MIN_TOP_SHARE * width * depth:
            return round(float(np.median(at)), 3)
    return None


def _crossings(corners: np.ndarray, height: float) -> np.ndarray:
    """Segments (K, 2, 2) in which the triangles (T, 3, 3) cut the level plane at ``height``."""
    above = corners[..., 2] > height
    cut = corners[above.any(1) & ~above.all(1)]
    above = cut[..., 2] > height
    alone = np.where(above.sum(1) == 1, above.argmax(1), (~above).argmax(1))  # the corner on its own side
    rows = np.arange(len(cut))
    single = cut[rows, alone]
    ends = []
    for step in (1, 2):
        other = cut[rows, (alone + step) % 3]
        share = (height - single[:, 2]) / (other[:, 2] - single[:, 2])
        ends.append(single[:, :2] + share[:, None] * (other[:, :2] - single[:, :2]))
    return np.stack(ends, 1) if len(cut) else np.zeros((0, 2, 2))
