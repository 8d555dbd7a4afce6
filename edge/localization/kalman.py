"""A Gaussian belief of a planar pose: predicted by odometry, corrected by measured poses."""

from dataclasses import dataclass

import numpy as np

from edge.pose import compose, rotation, wrap


@dataclass(frozen=True)
class PoseBelief:
    """Mean (3,) and covariance (3, 3) of a pose."""

    mean: np.ndarray
    covariance: np.ndarray

    def moved(self, motion: np.ndarray, noise: np.ndarray) -> "PoseBelief":
        """After ``motion`` (3,), a pose in the robot's frame, known up to ``noise`` (3, 3) in that frame.

        Extended Kalman prediction through the composition of poses (Smith, Self & Cheeseman 1990).
        """
        mean = compose(self.mean, motion)
        by_pose = np.array([[1.0, 0.0, self.mean[1] - mean[1]], [0.0, 1.0, mean[0] - self.mean[0]], [0.0, 0.0, 1.0]])
        by_motion = rotation(self.mean[2])
        return PoseBelief(mean, by_pose @ self.covariance @ by_pose.T + by_motion @ noise @ by_motion.T)

    def distance(self, measured: np.ndarray, noise: np.ndarray) -> float:
        """Squared Mahalanobis distance of a ``measured`` pose (3,) with covariance ``noise`` (3, 3)."""
        innovation = self._innovation(measured)
        return float(innovation @ np.linalg.solve(self.covariance + noise, innovation))

    def corrected(self, measured: np.ndarray, noise: np.ndarray) -> "PoseBelief":
        """After measuring the pose itself as ``measured`` (3,) with covariance ``noise`` (3, 3); Joseph form."""
        gain = np.linalg.solve(self.covariance + noise, self.covariance).T
        mean = self.mean + gain @ self._innovation(measured)
        mean[2] = wrap(mean[2])
        rest = np.eye(3) - gain
        return PoseBelief(mean, rest @ self.covariance @ rest.T + gain @ noise @ gain.T)

    def _innovation(self, measured: np.ndarray) -> np.ndarray:
        difference = measured - self.mean
        difference[2] = wrap(difference[2])
        return difference
