"""The inertial unit: a gyro about the vertical axis and two accelerometers, with bias and noise."""

from dataclasses import dataclass
from math import sqrt

import numpy as np


@dataclass(frozen=True)
class ImuConfig:
    """A consumer MEMS part, as its data sheet would put it at 50 Hz."""

    gyro_noise: float = 0.004  # rad/s
    gyro_bias: float = 0.005  # rad/s, standard deviation of the bias at power-up
    gyro_bias_walk: float = 2e-5  # rad/s per sqrt(s)
    acceleration_noise: float = 0.05  # m/s^2
    acceleration_bias: float = 0.03  # m/s^2


@dataclass(frozen=True, slots=True)
class ImuSample:
    """One reading in base_link."""

    stamp: float  # s
    turn_rate: float  # rad/s about z
    acceleration: tuple[float, float]  # m/s^2 along x (forward) and y (left)


class Imu:
    """Adds to the true motion what a real part would add."""

    def __init__(self, config: ImuConfig, period: float, rng: np.random.Generator | None):
        """``period`` [s] between readings; ``rng`` None makes a perfect part."""
        self._config, self._rng = config, rng
        self._walk = config.gyro_bias_walk * sqrt(period)
        self._gyro_bias = float(rng.normal(0.0, config.gyro_bias)) if rng is not None else 0.0
        biases = rng.normal(0.0, config.acceleration_bias, 2) if rng is not None else np.zeros(2)
        self._bias_x, self._bias_y = biases.tolist()

    def read(self, stamp: float, turn_rate: float, acceleration: tuple[float, float]) -> ImuSample:
        """Reading of a true turn rate [rad/s] and acceleration [m/s^2]."""
        if self._rng is None:
            return ImuSample(stamp, turn_rate, acceleration)
        config = self._config
        gyro, walk, ax, ay = self._rng.standard_normal(4).tolist()
        self._gyro_bias += self._walk * walk
        return ImuSample(
            stamp,
            turn_rate + self._gyro_bias + config.gyro_noise * gyro,
            (
                acceleration[0] + self._bias_x + config.acceleration_noise * ax,
                acceleration[1] + self._bias_y + config.acceleration_noise * ay,
            ),
        )
