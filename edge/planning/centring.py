"""Keeping an object in the picture while driving to it: [V] Sec. III-E, Eqs. 4–6, with the planar image Jacobian."""

from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel


@dataclass(frozen=True)
class CentringConfig:
    """Weights of the two costs, and when the object counts as centred."""

    orient_weight: float = 12.0  # m per squared unit of e/f: 10° off the axis cost as much as 0.37 m
    zoom_weight: float = 2.0  # m per m of depth; more than the path's 1, which leads on up to the object
    depth: float = 1.5  # m, d_thresh: nearer than 1.42, a level camera 0.88 m high loses the floor, and low things
    depth_tolerance: float = 0.10  # m
    angle_tolerance: float = np.radians(2.0)  # rad off the optical axis


@dataclass(frozen=True, slots=True)
class ImageTarget:
    """An object as the camera sees it now."""

    u: float  # px, column of the box centre
    depth: float  # m along the optical axis


def seen_after(target: ImageTarget, motion, camera: CameraModel) -> ImageTarget:
    """How a still object looks after a ``motion (3,)`` of the base; its depth is kept over 0.1 m, as in ``predict``."""
    x, y = camera.unproject(target.u, camera.centre[1], target.depth)[:2] - motion[:2]
    cos, sin = np.cos(motion[2]), np.sin(motion[2])
    ahead = max(float(cos * x + sin * y), camera.ahead + 0.1)
    (u,), _, (depth,) = camera.project([(ahead, cos * y - sin * x, camera.mount_height)])
    return ImageTarget(float(u), float(depth))


def image_jacobian(e, depth, camera: CameraModel) -> tuple:
    """Rates of e = u − u₀ [px] and of the depth Z [m] as ``(de/dv, de/dω, dZ/dv, dZ/dω)``, for arrays of one shape.

    For a camera ``ahead`` (a) and ``left`` (b) of the base centre: ė = e·v_z/Z + (f + e²/f)ω + f·a·ω/Z and
    Ż = −v_z − ω·e·Z/f with v_z = v − ωb.
    """
    f, a, b = camera.focal, camera.ahead, camera.left
    return e / depth, f + e * e / f + (f * a - e * b) / depth, np.full_like(e, -1.0), b - e * depth / f


def predict(target: ImageTarget, v: np.ndarray, omega: np.ndarray, dt: float, camera: CameraModel):
    """e [px] and Z [m], each ``(N, S + 1)``, of a still object along trajectories ``v, omega (N, S + 1)`` of the base.

    Speeds are taken as linear between the states; the Jacobian is integrated by Heun's rule, with Z kept over 0.1 m and
    e within three picture widths, where the object is long out of view.
    """
    e, depth = np.empty(v.shape), np.empty(v.shape)
    e[:, 0], depth[:, 0] = target.u - camera.centre[0], target.depth
    bound = 3.0 * camera.width

    def rates(e, depth, v, omega):
        de_dv, de_dw, dz_dv, dz_dw = image_jacobian(e, depth, camera)
        return de_dv * v + de_dw * omega, dz_dv * v + dz_dw * omega

    def advance(k, de, dz):
        return np.clip(e[:, k] + dt * de, -bound, bound), np.maximum(depth[:, k] + dt * dz, 0.1)

    for k in range(v.shape[1] - 1):
        de, dz = rates(e[:, k], depth[:, k], v[:, k], omega[:, k])
        de_end, dz_end = rates(*advance(k, de, dz), v[:, k + 1], omega[:, k + 1])
        e[:, k + 1], depth[:, k + 1] = advance(k, 0.5 * (de + de_end), 0.5 * (dz + dz_end))
    return e, depth


def centring_cost(e: np.ndarray, depth: np.ndarray, camera: CameraModel, config: CentringConfig) -> np.ndarray:
    """Orient and zoom costs ``(N, S)`` of the segments between states ``(N, S + 1)``, in metres of progress.

    Orient (Eqs. 4, 6) is the change of the squared horizontal error. Zoom (Eq. 5) as printed grows while driving to the
    object; here it is the change of |Z − d_thresh|, so that approaching is rewarded until d_thresh and not beyond.
    """
    orient = config.orient_weight * (e / camera.focal) ** 2
    zoom = config.zoom_weight * np.abs(depth - config.depth)
    return np.diff(orient + zoom, axis=1)


def centred(target: ImageTarget, camera: CameraModel, config: CentringConfig) -> bool:
    """Whether the object is in the middle column of the picture, within the tolerance."""
    return bool(abs(camera.bearing(target.u)) <= config.angle_tolerance)
