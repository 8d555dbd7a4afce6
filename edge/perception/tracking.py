"""A constant-velocity Kalman filter of the target's centre in the picture: Grad-CAM boxes jump ([V] Sec. III-C)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TrackerConfig:
    """Noise of the centre's motion and of its measurement."""

    acceleration: float = 60.0  # px/s^2, one sigma: turning at 1.5 rad/s moves the picture by 300 px/s within seconds
    centre_noise: float = 18.0  # px, one sigma: half a cell of the saliency map
    velocity_prior: float = 120.0  # px/s, one sigma of a new track: the camera may be turning
    gate: float = 13.8  # squared Mahalanobis distance, chi-square with 2 degrees of freedom at 99.9 %
    max_age: float = 1.5  # s without a measurement until the track is given up


class BoxTracker:
    """Tracks one box centre (u, v) [px]. State: u, v, du/dt, dv/dt."""

    _MEASURES = np.eye(2, 4)

    def __init__(self, config: TrackerConfig | None = None):
        self._config = config or TrackerConfig()
        self._state: np.ndarray | None = None
        self._covariance = np.zeros((4, 4))
        self._stamp = self._seen = 0.0

    @property
    def centre(self) -> tuple[float, float] | None:
        """Estimated (u, v) px, None without a track."""
        return None if self._state is None else (float(self._state[0]), float(self._state[1]))

    @property
    def velocity(self) -> tuple[float, float] | None:
        """Estimated px/s, None without a track."""
        return None if self._state is None else (float(self._state[2]), float(self._state[3]))

    @property
    def covariance(self) -> np.ndarray:
        """(4, 4) of the state; zeros without a track."""
        return self._covariance.copy()

    def update(self, stamp: float, centre: tuple[float, float] | None) -> tuple[float, float] | None:
        """Predict to ``stamp`` [s], then correct with a measured ``centre`` [px] (None: not seen); the estimate.

        A measurement outside the gate is taken for a jump of the saliency and ignored; when nothing fits for
        ``max_age`` the track ends, and the next measurement starts a new one.
        """
        if self._state is not None:
            self._predict(max(0.0, stamp - self._stamp))
            if stamp - self._seen > self._config.max_age:
                self._state, self._covariance = None, np.zeros((4, 4))
        self._stamp = stamp
        if centre is None:
            return self.centre
        measured = np.asarray(centre, float)
        if self._state is None:
            self._start(measured)
            self._seen = stamp
        elif self._correct(measured):
            self._seen = stamp
        return self.centre

    def _start(self, measured: np.ndarray) -> None:
        position, velocity = self._config.centre_noise**2, self._config.velocity_prior**2
        self._state = np.array([*measured, 0.0, 0.0])
        self._covariance = np.diag([position, position, velocity, velocity])

    def _predict(self, dt: float) -> None:
        motion = np.eye(4)
        motion[0, 2] = motion[1, 3] = dt
        # Acceleration is white and constant over a step (Bar-Shalom et al. 2001, eq. 6.3.2-4).
        push = np.array([[dt**2 / 2, 0], [0, dt**2 / 2], [dt, 0], [0, dt]])
        self._state = motion @ self._state
        self._covariance = motion @ self._covariance @ motion.T + push @ push.T * self._config.acceleration**2

    def _correct(self, measured: np.ndarray) -> bool:
        innovation = measured - self._state[:2]
        spread = self._covariance[:2, :2] + np.eye(2) * self._config.centre_noise**2
        if innovation @ np.linalg.solve(spread, innovation) > self._config.gate:
            return False
        gain = np.linalg.solve(spread, self._covariance[:2]).T
        self._state = self._state + gain @ innovation
        self._covariance = (np.eye(4) - gain @ self._MEASURES) @ self._covariance
        return True
