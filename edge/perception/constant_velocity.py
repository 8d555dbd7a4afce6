"""A Kalman filter of a point in a plane that keeps its velocity, but for white acceleration."""

import numpy as np


class ConstantVelocity:
    """State: x, y, dx/dt, dy/dt, in the measurements' unit; its ``covariance`` (4, 4)."""

    _MEASURES = np.eye(2, 4)

    def __init__(self, measured, noise: float, speed: float, acceleration: float):
        """Starts at a ``measured (2,)`` point. One sigma each: of that, of the first speed, of the acceleration."""
        self.state = np.array([*measured, 0.0, 0.0])
        self.covariance = np.diag([noise**2, noise**2, speed**2, speed**2])
        self._acceleration = acceleration

    @property
    def position(self) -> np.ndarray:
        """(2,), read-only by convention, as is ``velocity``."""
        return self.state[:2]

    @property
    def velocity(self) -> np.ndarray:
        """(2,) a second."""
        return self.state[2:]

    def predict(self, dt: float) -> None:
        """Let ``dt`` [s] pass. Acceleration is constant over a step (Bar-Shalom et al. 2001, eq. 6.3.2-4)."""
        motion = np.eye(4)
        motion[0, 2] = motion[1, 3] = dt
        push = np.array([[dt**2 / 2, 0], [0, dt**2 / 2], [dt, 0], [0, dt]])
        self.state = motion @ self.state
        self.covariance = motion @ self.covariance @ motion.T + push @ push.T * self._acceleration**2

    def distance(self, measured, noise: float) -> float:
        """Squared Mahalanobis distance of a ``measured (2,)`` point, itself known to ``noise``, one sigma."""
        innovation = np.asarray(measured, float) - self.position
        return float(innovation @ np.linalg.solve(self._spread(noise), innovation))

    def correct(self, measured, noise: float) -> None:
        """Take in a ``measured (2,)`` point, known to ``noise``, one sigma."""
        gain = np.linalg.solve(self._spread(noise), self.covariance[:2]).T
        self.state = self.state + gain @ (np.asarray(measured, float) - self.position)
        self.covariance = (np.eye(4) - gain @ self._MEASURES) @ self.covariance

    def _spread(self, noise: float) -> np.ndarray:
        """Covariance (2, 2) of what a measurement will be."""
        return self.covariance[:2, :2] + np.eye(2) * noise**2
