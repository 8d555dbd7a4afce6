"""How well the relative pose of two nodes is known."""

from dataclasses import dataclass

import numpy as np

from edge.pose import rotation


@dataclass(frozen=True)
class MotionNoise:
    """Standard deviations of a relative pose from wheel odometry corrected by scan matching."""

    position: float = 0.01  # m, floor: a fifth of a grid cell, what scan matching resolves
    position_per_metre: float = 0.03  # m per m driven; a small base on carpet
    heading: float = 0.005  # rad, floor: 0.3 deg
    heading_per_metre: float = 0.01  # rad per m driven
    heading_per_radian: float = 0.03  # rad per rad turned

    def information(self, transform):
        """Information matrix ``(3, 3)`` of the relative pose ``transform (3,)``, in the frame of its first node."""
        distance, turn = np.hypot(transform[0], transform[1]), abs(transform[2])
        position = self.position + self.position_per_metre * distance
        heading = self.heading + self.heading_per_metre * distance + self.heading_per_radian * turn
        return np.diag([position**-2, position**-2, heading**-2])


def in_frame(covariance, heading):
    """A covariance ``(3, 3)`` of the map frame, in that of a node with this ``heading`` [rad]."""
    turn = rotation(-heading)
    return turn @ covariance @ turn.T
