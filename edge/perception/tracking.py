"""A constant-velocity Kalman filter of the target's centre in the picture: Grad-CAM boxes jump ([V] Sec. III-C)."""

from dataclasses import dataclass

import numpy as np

from edge.perception.constant_velocity import ConstantVelocity


@dataclass(frozen=True)
class TrackerConfig:
    """Noise of the centre's motion and of its measurement."""

    acceleration: float = 20.0  # px/s^2, one sigma: of what the camera's own motion does not explain
    centre_noise: float = 18.0  # px, one sigma: half a cell of the saliency map
    velocity_prior: float = 20.0  # px/s, one sigma of a new track: most things stand still
    gate: float = 13.8  # squared Mahalanobis distance, chi-square with 2 degrees of freedom at 99.9 %
    max_age: float = 1.5  # s without a measurement until the track is given up


class BoxTracker:
    """Tracks one box centre (u, v) [px]."""

    def __init__(self, config: TrackerConfig | None = None):
        self._config = config or TrackerConfig()
        self._filter: ConstantVelocity | None = None
        self._stamp = self._seen = 0.0

    @property
    def centre(self) -> tuple[float, float] | None:
        """Estimated (u, v) px, None without a track."""
        return None if self._filter is None else tuple(self._filter.position.tolist())

    @property
    def velocity(self) -> tuple[float, float] | None:
        """Estimated px/s, None without a track."""
        return None if self._filter is None else tuple(self._filter.velocity.tolist())

    @property
    def covariance(self) -> np.ndarray:
        """(4, 4) of centre and velocity; zeros without a track."""
        return np.zeros((4, 4)) if self._filter is None else self._filter.covariance.copy()

    def shift(self, du: float) -> None:
        """The camera has turned or moved: a still object is now ``du`` [px] further right in its picture."""
        if self._filter is not None:
            self._filter.state[0] += du

    def update(self, stamp: float, centre: tuple[float, float] | None) -> tuple[float, float] | None:
        """Predict to ``stamp`` [s], then correct with a measured ``centre`` [px] (None: not seen); the estimate.

        A measurement outside the gate is taken for a jump of the saliency and ignored; when nothing fits for
        ``max_age`` the track ends, and the next measurement starts a new one.
        """
        if self._filter is not None:
            self._filter.predict(max(0.0, stamp - self._stamp))
            if stamp - self._seen > self._config.max_age:
                self._filter = None
        self._stamp = stamp
        if centre is None:
            return self.centre
        config = self._config
        if self._filter is None:
            self._filter = ConstantVelocity(centre, config.centre_noise, config.velocity_prior, config.acceleration)
            self._seen = stamp
        elif self._filter.distance(centre, config.centre_noise) <= config.gate:
            self._filter.correct(centre, config.centre_noise)
            self._seen = stamp
        return self.centre
