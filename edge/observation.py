"""What the robot is told in one control step, and what it answers. Same types in lock-step and behind zenoh."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class LaserScan:
    """One turn of the 2-D lidar. Beam i points at ``angle_min + i * angle_increment`` [rad] in base_link."""

    stamp: float  # s
    ranges: np.ndarray  # (N,) float32 m; inf or NaN = no return
    angle_min: float
    angle_increment: float
    range_max: float  # m
    odom: np.ndarray  # (3,) base pose in the odom frame at the stamp


@dataclass(frozen=True, slots=True)
class RgbdFrame:
    """One colour picture and its registered depth."""

    stamp: float  # s
    rgb: np.ndarray  # (H, W, 3) uint8
    depth: np.ndarray  # (H, W) float32 m along the optical axis; 0 or NaN = no return
    odom: np.ndarray  # (3,) base pose in the odom frame at the stamp


@dataclass(frozen=True, slots=True)
class Observation:
    """State of the base now, with the newest scan and frame when they are new since the last observation."""

    stamp: float  # s
    odom: np.ndarray  # (3,) base pose in the odom frame, drifts
    twist: np.ndarray  # (2,) measured v [m/s], omega [rad/s]
    scan: LaserScan | None = None
    frame: RgbdFrame | None = None
    bumper: bool = False


@dataclass(frozen=True, slots=True)
class Twist:
    """Velocity command: forward v [m/s] and turn omega [rad/s], counter-clockwise."""

    v: float = 0.0
    omega: float = 0.0


STOP = Twist()
