"""The robot's forward-looking pinhole camera: intrinsics, and where it sits on the base."""

from dataclasses import dataclass
from math import radians, tan

import numpy as np


@dataclass(frozen=True)
class CameraModel:
    """Level pinhole camera, optical axis along the base's x axis. Pixel (0, 0) has its centre at u = 0, v = 0."""

    width: int = 320
    height: int = 240
    hfov: float = radians(79.0)  # rad, [V] Sec. IV
    mount_height: float = 0.88  # m above the floor
    ahead: float = 0.10  # m from the base centre to the optical centre
    left: float = 0.0  # m
    min_depth: float = 0.5  # m
    max_depth: float = 5.0  # m

    @property
    def focal(self) -> float:
        """Focal length [px], equal in u and v."""
        return self.width / 2 / tan(self.hfov / 2)

    @property
    def centre(self) -> tuple[float, float]:
        """Principal point (u0, v0) [px]."""
        return (self.width - 1) / 2, (self.height - 1) / 2

    def bearing(self, u):
        """Bearing [rad] of pixel column(s) ``u`` from the optical axis; left is positive."""
        return np.arctan2(self.centre[0] - np.asarray(u, float), self.focal)

    def project(self, points):
        """Points ``(N, 3)`` in base_link [m] to ``u, v`` [px] and depth along the axis [m], each ``(N,)``.

        Points behind the camera get a depth <= 0; their u and v mean nothing.
        """
        points = np.asarray(points, float)
        z = points[:, 0] - self.ahead
        safe = np.where(np.abs(z) < 1e-9, 1e-9, z)
        u = self.centre[0] - self.focal * (points[:, 1] - self.left) / safe
        v = self.centre[1] - self.focal * (points[:, 2] - self.mount_height) / safe
        return u, v, z

    def unproject(self, u, v, depth):
        """Pixels and depths, broadcast to one shape S, to points ``S + (3,)`` in base_link [m]."""
        u, v, depth = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float), np.asarray(depth, float))
        y = self.left + (self.centre[0] - u) * depth / self.focal
        z = self.mount_height + (self.centre[1] - v) * depth / self.focal
        return np.stack([self.ahead + depth, y, z], axis=-1)
