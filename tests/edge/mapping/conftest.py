"""Maps drawn by hand, and a lidar and depth camera among walls and boxes whose every distance is known."""

import numpy as np
import pytest

from edge.mapping import map_bytes
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan


def draw(picture: str, resolution=0.1, repeat=1):
    """Grid of a picture: '#' occupied, '.' free, ' ' unknown; its last line lies at y = 0."""
    lines = [line for line in picture.splitlines() if line]
    width = max(len(line) for line in lines)
    codes = {"#": 20, ".": -8, " ": 0}
    layer = np.array([[codes[sign] for sign in line.ljust(width)] for line in reversed(lines)], np.int8)
    layer = np.kron(layer, np.ones((repeat, repeat), np.int8))
    return OccupancyGrid.from_bytes(map_bytes.pack(resolution, np.zeros(2), np.stack([layer, 0 * layer, 0 * layer])))


def cast(pose, walls, beams=360, range_max=8.0):
    """Scan of segments ``walls (M, 2, 2)`` from ``pose``, beam by beam and wall by wall."""
    increment = 2 * np.pi / beams
    angles = pose[2] - np.pi + increment * np.arange(beams)
    along, first = walls[:, 1] - walls[:, 0], walls[:, 0] - pose[:2]
    ranges = np.full(beams, np.inf)
    for i, angle in enumerate(angles):
        ray = np.array([np.cos(angle), np.sin(angle)])
        for a, e in zip(first, along):
            system = np.stack([ray, -e], axis=1)
            if abs(np.linalg.det(system)) > 1e-12:
                t, u = np.linalg.solve(system, a)
                if t > 0 and 0 <= u <= 1:
                    ranges[i] = min(ranges[i], t)
    ranges[ranges > range_max] = np.inf
    return LaserScan(0.0, ranges.astype(np.float32), -np.pi, increment, range_max, np.array(pose, float))


def rectangle(x0, y0, x1, y1):
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def look(pose, boxes, camera, floor=True):
    """Exact depth image of boxes ``(M, 6)`` x0, y0, z0, x1, y1, z1 on a floor, by slab intersection; 0 = no return."""
    v, u = np.mgrid[: camera.height, : camera.width]
    body = camera.unproject(u, v, 1.0) - camera.unproject(u, v, 0.0)  # one metre along the axis
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    forward, left, up = np.moveaxis(body, -1, 0)
    rays = np.stack([cos * forward - sin * left, sin * forward + cos * left, up], axis=-1)
    x, y = pose[0] + cos * camera.ahead - sin * camera.left, pose[1] + sin * camera.ahead + cos * camera.left
    eye = np.array([x, y, camera.mount_height])
    depth = np.full(v.shape, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        if floor:
            depth = np.where(rays[..., 2] < 0, -eye[2] / rays[..., 2], depth)
        for box in np.asarray(boxes, float):
            a, b = (box[:3] - eye) / rays, (box[3:] - eye) / rays
            enter, leave = np.minimum(a, b).max(-1), np.maximum(a, b).min(-1)
            depth = np.where((enter < leave) & (enter > 0), np.minimum(depth, enter), depth)
    depth[(depth < camera.min_depth) | (depth > camera.max_depth)] = 0
    return depth.astype(np.float32)


@pytest.fixture(scope="session")
def depth_of():
    return look


@pytest.fixture(scope="session")
def drawn():
    return draw


@pytest.fixture(scope="session")
def scan_of():
    return cast


@pytest.fixture(scope="session")
def walls_of():
    return rectangle
