"""Planar poses: arrays ``(..., 3)`` of x [m], y [m], theta [rad] (REP-103: x forward, y left, theta to the left)."""

import numpy as np


def wrap(angle):
    """Angle [rad] of any shape, wrapped to [-pi, pi)."""
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


def rotation(angle):
    """What turns the x and y of a pose's error or motion by ``angle`` [rad] of shape S: ``S + (3, 3)``."""
    angle = np.asarray(angle, float)
    turn = np.zeros((*angle.shape, 3, 3))
    turn[..., 0, 0] = turn[..., 1, 1] = np.cos(angle)
    turn[..., 1, 0] = np.sin(angle)
    turn[..., 0, 1] = -turn[..., 1, 0]
    turn[..., 2, 2] = 1.0
    return turn


def compose(a, b):
    """Pose ``b``, given in the frame of pose ``a``, in the frame that ``a`` is given in. Shapes broadcast."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    cos, sin = np.cos(a[..., 2]), np.sin(a[..., 2])
    return np.stack(
        [
            a[..., 0] + cos * b[..., 0] - sin * b[..., 1],
            a[..., 1] + sin * b[..., 0] + cos * b[..., 1],
            wrap(a[..., 2] + b[..., 2]),
        ],
        axis=-1,
    )


def between(a, b):
    """Pose ``b`` seen from pose ``a``: ``compose(a, between(a, b)) == b``. Shapes broadcast."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    cos, sin = np.cos(a[..., 2]), np.sin(a[..., 2])
    dx, dy = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    return np.stack([cos * dx + sin * dy, -sin * dx + cos * dy, wrap(b[..., 2] - a[..., 2])], axis=-1)


def has_moved(before, after, distance, angle):
    """Whether between two poses (3,) there is a way of ``distance`` [m], or a turn of ``angle`` [rad], or more."""
    x, y, turn = between(before, after)
    return bool(np.hypot(x, y) >= distance or abs(turn) >= angle)


def transform(pose, points):
    """Points ``(N, 2)`` given in the frame of one ``pose (3,)``, in the frame that the pose is given in."""
    x, y, theta = pose
    cos, sin = np.cos(theta), np.sin(theta)
    points = np.asarray(points)
    return np.stack([x + cos * points[:, 0] - sin * points[:, 1], y + sin * points[:, 0] + cos * points[:, 1]], axis=-1)
