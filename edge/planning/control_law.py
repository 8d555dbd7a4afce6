"""Smooth control law towards a target pose, and its closed-loop roll-outs (Park, Kuipers 2011; Park, Johnson, Kuipers
2012, "MPEPC"; used by [V] Sec. III-D).

Egocentric coordinates of a target: distance r, θ = target heading − line of sight, δ = robot heading − line of sight.
"""

from dataclasses import dataclass
from math import atan, atan2, cos, hypot, pi, sin, sqrt, tau

import numpy as np

from edge.pose import wrap


@dataclass(frozen=True)
class ControlLawConfig:
    """Gains of the law, limits of the base, and the clock of the roll-outs."""

    k1: float = 1.2  # how early the approach bends to the target's heading (Vulcan)
    k2: float = 3.0  # how fast the heading joins that bend (Vulcan)
    beta: float = 0.4  # how much curvature slows the robot, with λ = 2 (Vulcan, nav2)
    v_max: float = 0.6  # m/s, the base
    omega_max: float = 1.5  # rad/s, the base
    acceleration: float = 0.8  # m/s², comfortable for a robot 1 m tall
    brake: float = 1.6  # m/s², for who runs into the robot's way; half of what would make it lean
    angular_acceleration: float = 4.0  # rad/s²
    r_slow: float = 0.6  # m from the target, where the robot begins to slow down; 1.5-2 in the sources for v = 1.5 m/s
    v_min: float = 0.08  # m/s, so that the approach ends; below the base hardly moves
    turn_first: float = 0.7  # rad off the law's manifold from which the robot turns on the spot before it drives
    turn_gain: float = 2.5  # 1/s, of turns on the spot
    turn_rate: float = 1.2  # rad/s, of turns on the spot: below omega_max, pictures taken meanwhile stay sharp
    r_align: float = 0.04  # m; nearer than this the law is singular (κ grows as 1/r) and only the heading is served
    dt: float = 0.05  # s, step of the simulation
    steps: int = 100  # 5 s of simulation
    every: int = 4  # steps between evaluated states, 0.2 s


@dataclass(frozen=True, slots=True)
class RollOuts:
    """States of N trajectories at S + 1 evaluated times, the first of them now; each ``(N, S + 1)``."""

    x: np.ndarray  # m
    y: np.ndarray  # m
    heading: np.ndarray  # rad, not wrapped
    v: np.ndarray  # m/s
    omega: np.ndarray  # rad/s
    command: np.ndarray  # (N, 2) v, omega at the end of the control step that is commanded now

    def pick(self, i: int) -> "RollOuts":
        """The i-th trajectory alone."""
        return RollOuts(*(getattr(self, name)[i : i + 1] for name in self.__slots__))


def egocentric(pose, target, config: ControlLawConfig):
    """(r, θ, δ) of target poses ``(..., 3)`` seen from a robot ``pose (3,)``; angles wrapped.

    Within ``r_align`` the line of sight means nothing; it is taken along the heading: θ = 0, δ = heading error.
    """
    target = np.asarray(target, float)
    dx, dy = target[..., 0] - pose[0], target[..., 1] - pose[1]
    r = np.hypot(dx, dy)
    line = np.where(r < config.r_align, target[..., 2], np.arctan2(dy, dx))
    return r, wrap(target[..., 2] - line), wrap(pose[2] - line)


def target_pose(pose, r, theta, delta):
    """Inverse of ``egocentric``: target poses ``(..., 3)``."""
    line = pose[2] - np.asarray(delta, float)
    return np.stack([pose[0] + r * np.cos(line), pose[1] + r * np.sin(line), wrap(line + theta)], axis=-1)


def control_law(v_max: float, config: ControlLawConfig):
    """The law with the speed ``v_max`` [m/s]: a function of ``egocentric``'s (r > 0, θ, δ) that returns (v, ω).

    κ = −[k₂(δ − atan(−k₁θ)) + (1 + k₁/(1 + (k₁θ)²)) sin δ] / r, v = v_max/(1 + βκ²) slowed towards the target, ω = κv.
    Two cases are added to the paper's law, which would crawl along wide arcs and is singular at the target: far off
    the manifold the robot turns on the spot first, and at the target it turns to the target's heading.
    """
    k1, k2, beta, v_low = config.k1, config.k2, config.beta, min(config.v_min, v_max)
    r_align, r_slow, turn_first, two_a = config.r_align, config.r_slow, config.turn_first, 2.0 * config.acceleration
    gain, rate, omega_max = config.turn_gain, config.turn_rate, config.omega_max

    def velocities(r: float, theta: float, delta: float) -> tuple[float, float]:
        k_theta = k1 * theta
        off = delta + atan(k_theta)
        if r < r_align or off > turn_first or off < -turn_first:
            turn = -gain * off
            return 0.0, rate if turn > rate else -rate if turn < -rate else turn
        kappa = (k2 * off + (1.0 + k1 / (1.0 + k_theta * k_theta)) * sin(delta)) / -r
        ramp, v = v_max * r / r_slow, v_max / (1.0 + beta * kappa * kappa)
        if ramp < v or two_a * r < v * v:
            v = min(v, max(min(ramp, sqrt(two_a * r)), v_low))
        omega = kappa * v
        if omega > omega_max or omega < -omega_max:
            return omega_max / abs(kappa), omega_max if kappa > 0 else -omega_max
        return v, omega

    return velocities


def roll_out(pose, twist, targets: np.ndarray, control_period: float, config: ControlLawConfig) -> RollOuts:
    """Closed-loop trajectories from one ``pose (3,)`` and ``twist (2,)`` to ``targets (N, 4)``: x, y, heading, v_max.

    The base follows the law as far as its accelerations allow. With a negative ``v_max`` it drives backwards, as a
    robot that looks the other way would drive forwards. In plain floats, one after the other: for fewer than some
    thirty targets that takes less time than arrays, whose every step is sixty calls of numpy whatever N is.
    """
    start = tuple(float(value) for value in (*pose, *twist))
    rolled = [_roll_out_one(*start, *target, control_period, config) for target in np.asarray(targets, float).tolist()]
    states, commands = zip(*rolled)
    return RollOuts(*np.ascontiguousarray(np.array(states).transpose(2, 0, 1)), np.array(commands))


def _roll_out_one(x, y, heading, v, omega, tx, ty, th, v_max, control_period, config):
    """The states of one trajectory, a tuple for each evaluated time, and the command (v, ω)."""
    facing, sign = (pi, -1.0) if v_max < 0 else (0.0, 1.0)  # from the robot's heading to where it drives
    th, heading, v = th + facing, heading + facing, v * sign
    law, r_align = control_law(abs(v_max), config), config.r_align
    dt, dw = config.dt, config.angular_acceleration * config.dt
    slower = config.brake * dt
    faster = slower if sign < 0 else config.acceleration * dt
    commanded = max(1, round(control_period / dt))
    states, command = [(x, y, heading - facing, v * sign, omega)], None
    for step in range(1, config.steps + 1):
        dx, dy = tx - x, ty - y
        r = max(hypot(dx, dy), 1e-6)
        line = th if r < r_align else atan2(dy, dx)
        want_v, want_omega = law(r, (th - line + pi) % tau - pi, (heading - line + pi) % tau - pi)
        up, down = (slower if v < 0 else faster), (slower if v > 0 else faster)
        v = v + up if want_v > v + up else v - down if want_v < v - down else want_v
        omega = omega + dw if want_omega > omega + dw else omega - dw if want_omega < omega - dw else want_omega
        middle = heading + 0.5 * dt * omega
        x, y, heading = x + dt * v * cos(middle), y + dt * v * sin(middle), heading + dt * omega
        if step == commanded:
            command = (v * sign, omega)
        if step % config.every == 0:
            states.append((x, y, heading - facing, v * sign, omega))
    return states, command
