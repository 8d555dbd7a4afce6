"""Plane geometry that the house, its physics and its lidar share. Polygons are ``(N, 2)`` arrays of corners [m]."""

import numpy as np


def edges(polygon):
    """Sides of a closed polygon: segments ``(N, 2, 2)``, each from a corner to the next."""
    polygon = np.asarray(polygon, float)
    return np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1)


def band(a, b, width, extend_a=0.0, extend_b=0.0):
    """Counter-clockwise rectangle ``(4, 2)`` of ``width`` around the segment a-b, lengthened at either end [m].

    Raises ValueError when a and b coincide.
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    length = np.hypot(*(b - a))
    if not length >= 1e-6:
        raise ValueError(f"a wall or door from {a.tolist()} to {b.tolist()} has no length")
    along = (b - a) / length
    across = np.array([-along[1], along[0]]) * width / 2
    a, b = a - along * extend_a, b + along * extend_b
    return np.stack([a - across, b - across, b + across, a + across])


def contains(polygon, points):
    """Which of the ``points (..., 2)`` lie inside a simple polygon, convex or not (even-odd rule)."""
    a, b = edges(polygon).transpose(1, 0, 2)
    points = np.asarray(points, float)
    x, y = points[..., None, 0], points[..., None, 1]
    straddles = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    crosses = straddles & (x < a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0]))
    return crosses.sum(axis=-1) % 2 == 1


def penetration(a, b):
    """How deep two convex polygons overlap [m]: the shortest push that parts them; <= 0 when they are apart.

    Separating-axis test over the normals of both (Gottschalk 1996). A negative value is a lower bound of the gap.
    """
    sides = np.concatenate([a - np.roll(a, 1, axis=0), b - np.roll(b, 1, axis=0)])
    normals = np.stack([-sides[:, 1], sides[:, 0]], axis=1)
    lengths = np.hypot(normals[:, 0], normals[:, 1])
    normals = normals[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    along_a, along_b = normals @ a.T, normals @ b.T
    overlaps = np.minimum(along_a.max(1) - along_b.min(1), along_b.max(1) - along_a.min(1))
    return float(overlaps.min())


def distance_to_segments(points, segments):
    """Distance [m] ``(...)`` from ``points (..., 2)`` to the nearest of ``segments (M, 2, 2)``; inf when M is 0."""
    points, segments = np.asarray(points, float), np.asarray(segments, float)
    if len(segments) == 0:
        return np.full(points.shape[:-1], np.inf)
    a, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    offset = points[..., None, :] - a
    share = (offset * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-12)
    away = offset - np.clip(share, 0.0, 1.0)[..., None] * along
    return np.sqrt((away**2).sum(-1)).min(axis=-1)
