"""Trajectories that meet something that moves: collision with a body where it will be (Park, Johnson, Kuipers 2012)."""

from dataclasses import dataclass

import numpy as np

from edge.perception.movers import Mover
from edge.planning.control_law import RollOuts


@dataclass(frozen=True)
class EncounterConfig:
    """How far to keep from a body, and how far ahead to believe in its walk."""

    margin: float = -0.08  # m beyond both radii; negative, so that of two ways that touch, the better one is told
    margin_per_speed: float = 0.10  # m per m/s of the robot
    sigma: float = 0.10  # m, softness of a collision now: two sigmas of where a body is


def encounter(out: RollOuts, mover: Mover, radius: float, segment: float, config: EncounterConfig) -> np.ndarray:
    """Probability ``(N, S + 1)`` that a robot of ``radius`` [m] collides with ``mover`` at each state of a trajectory.

    The body keeps its velocity, as far as that is known: of who has just come into sight, it is not. The i-th states
    are ``i * segment`` seconds ahead: p_c = exp(−(d/σ)²), with d the distance beyond a margin and σ growing with the
    doubt of where the body will be. As with walls (see ``survival``), a robot within the margin may get away, but not
    nearer.
    """
    ahead = segment * np.arange(out.x.shape[1])
    x, y = mover.position[:, None] + mover.velocity[:, None] * ahead
    gap = np.hypot(out.x - x, out.y - y) - radius - mover.radius
    sigma = np.hypot(config.sigma, mover.doubt * ahead)
    margin = config.margin + config.margin_per_speed * np.abs(out.v)
    beyond = gap - np.minimum(margin, np.maximum.accumulate(gap, axis=1) - 2.5 * config.sigma)
    return np.exp(-((np.maximum(beyond, 0.0) / sigma) ** 2))
