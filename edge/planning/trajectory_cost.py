"""Expected cost of trajectories: survival, action and collision ([V] Sec. III-D; Park, Johnson, Kuipers 2012)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from edge.mapping.grid import GridFrame
from edge.perception.movers import Mover
from edge.planning.control_law import RollOuts
from edge.planning.encounter import EncounterConfig, encounter


@dataclass(frozen=True)
class CostConfig:
    """Weights in metres of progress, and the model of what a robot survives."""

    radius: float = 0.18  # m, the robot
    margin: float = 0.02  # m beyond the radius: half a cell, which is how well the map knows a wall
    margin_per_speed: float = 0.08  # m per m/s
    sigma: float = 0.02  # m, softness of a collision at rest (Vulcan)
    sigma_fast: float = 0.06  # m, at 0.6 m/s (Vulcan)
    v_weight: float = 0.1  # action cost per second and (m/s)²; Vulcan's 0.3 outweighs half of the progress at 0.6 m/s
    omega_weight: float = 0.02  # (Vulcan 0.3, for a slower turning robot)
    acceleration_weight: float = 0.05  # (Vulcan 0.2)
    angular_acceleration_weight: float = 0.003  # (Vulcan 0.2)
    collision: float = 0.5  # per segment not survived, and as much again per unit of |v| + |ω| (Vulcan)
    discount: float = 0.97  # per segment (Vulcan)
    encounter: EncounterConfig = field(default_factory=EncounterConfig)


def look_up(clearance: np.ndarray, frame: GridFrame, x, y) -> np.ndarray:
    """Bilinear clearance [m] at x, y [m] of any shape; 0 outside the grid."""
    rows, cols = clearance.shape
    col = (np.asarray(x) - frame.origin[0]) / frame.resolution - 0.5
    row = (np.asarray(y) - frame.origin[1]) / frame.resolution - 0.5
    inside = (row > -0.5) & (row < rows - 0.5) & (col > -0.5) & (col < cols - 0.5)
    row, col = np.clip(row, 0, rows - 1.001), np.clip(col, 0, cols - 1.001)
    r, c = row.astype(np.intp), col.astype(np.intp)
    fr, fc = row - r, col - c
    flat, at = clearance.ravel(), r * cols + c
    low = flat[at] * (1 - fc) + flat[at + 1] * fc
    high = flat[at + cols] * (1 - fc) + flat[at + cols + 1] * fc
    return (low * (1 - fr) + high * fr) * inside


def survival(
    out: RollOuts,
    clearance: np.ndarray,
    frame: GridFrame,
    config: CostConfig,
    movers: Sequence[Mover] = (),
    segment: float = 0.2,
) -> np.ndarray:
    """Probability ``(N, S)`` that the robot is unharmed at the end of each segment of ``segment`` seconds.

    p_s = Π(1 − exp(−(d/σ)²)) with d the distance beyond a margin that grows with speed, as σ does. A robot that stands
    nearer to an obstacle than its margin would find every way out deadly; so the margin is never more than the best
    clearance that the trajectory has had so far: it may leave, but not come nearer again. ``movers`` are met where they
    will be by then (see ``encounter``).
    """
    here = look_up(clearance, frame, out.x, out.y)
    speed = np.abs(out.v)
    sigma = config.sigma + (config.sigma_fast - config.sigma) * np.minimum(speed / 0.6, 1.0)
    margin = config.radius + config.margin + config.margin_per_speed * speed
    d = here - np.minimum(margin, np.maximum.accumulate(here, axis=1) - 2.5 * sigma)
    unharmed = 1.0 - np.exp(-((np.maximum(d, 0.0) / sigma) ** 2))
    for mover in movers:
        unharmed *= 1.0 - encounter(out, mover, config.radius, segment, config.encounter)
    return np.cumprod(unharmed[:, 1:], axis=1)


def expected_cost(out: RollOuts, alive: np.ndarray, gain: np.ndarray, segment: float, config: CostConfig) -> np.ndarray:
    """Cost ``(N,)`` [m]: Σ γⁱ [p_s·progress + action + (1 − p_s)·collision] over segments of ``segment`` seconds.

    ``alive (N, S)`` is the survival, ``gain (N, S)`` the change of distance to go in each segment, negative is good.
    """
    v, omega = out.v[:, 1:], out.omega[:, 1:]
    action = segment * (config.v_weight * v * v + config.omega_weight * omega * omega)
    change = config.acceleration_weight * np.diff(out.v, axis=1) ** 2
    action += (change + config.angular_acceleration_weight * np.diff(out.omega, axis=1) ** 2) / segment
    harm = (1.0 - alive) * config.collision * (1.0 + np.abs(v) + np.abs(omega))
    return (alive * gain + action + harm) @ config.discount ** np.arange(v.shape[1])
