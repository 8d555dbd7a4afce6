"""The base's own idea of where it is: an extended Kalman filter over wheel encoders and gyro."""

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

X, Y, THETA, SPEED, TURN, BIAS = range(6)


@dataclass(frozen=True)
class OdometryConfig:
    """Noise that the filter believes in; of the order of what BaseConfig and ImuConfig produce."""

    speed_walk: float = 1.5  # m/s per sqrt(s): up to the ramps of the firmware
    turn_walk: float = 8.0  # rad/s per sqrt(s)
    bias_walk: float = 2e-5  # rad/s per sqrt(s)
    bias_start: float = 0.02  # rad/s, standard deviation at power-up, before the first rest
    encoder_floor: float = 0.004  # m/s; one tick in 20 ms
    speed_share: float = 0.03  # of the speed: slip
    turn_share: float = 0.2  # of the wheels' speeds; large, because uneven tyres err always to the same side
    gyro: float = 0.004  # rad/s; ImuConfig.gyro_noise
    rest: float = 1e-4  # m/s and rad/s; how well "no tick on either wheel" means "no motion"


class Odometry:
    """State x, y, theta, v, omega, gyro bias; constant-velocity arcs between updates.

    Measured are the forward speed and turn rate of the wheels and the gyro's turn rate plus bias. The bias is seen best
    while the robot rests, which the filter knows from encoders that do not move.
    """

    def __init__(self, config: OdometryConfig, wheel_radius, wheel_separation, ticks_per_turn, period):
        self._config, self._separation, self._period = config, wheel_separation, period
        self._tick = 2 * pi / ticks_per_turn * wheel_radius  # m
        self._ticks = (0, 0)
        self._rest = 0.0  # s without a tick
        self._filter = _ArcFilter(dim_x=6, dim_z=3)
        self._filter.x = np.zeros(6)
        self._filter.P = np.diag([0.0, 0.0, 0.0, 0.0, 0.0, config.bias_start**2])
        walks = np.array([0.0, 0.0, 0.0, config.speed_walk, config.turn_walk, config.bias_walk])
        self._filter.period, self._filter.walk = period, np.diag(walks**2 * period)
        self._jacobian = np.zeros((3, 6))
        self._jacobian[0, SPEED] = self._jacobian[1, TURN] = self._jacobian[2, TURN] = self._jacobian[2, BIAS] = 1.0

    @property
    def pose(self) -> np.ndarray:
        """Pose ``(3,)`` in the odom frame; (0, 0, 0) at power-up. Theta in [-pi, pi)."""
        x = self._filter.x
        return np.array([x[X], x[Y], (x[THETA] + pi) % (2 * pi) - pi])

    @property
    def twist(self) -> np.ndarray:
        """Forward speed [m/s] and turn rate [rad/s], ``(2,)``."""
        return self._filter.x[[SPEED, TURN]]

    @property
    def covariance(self) -> np.ndarray:
        """Of the pose, ``(3, 3)``; grows without bound, as dead reckoning does."""
        return self._filter.P[:3, :3].copy()

    def update(self, ticks: tuple[int, int], gyro: float) -> None:
        """One period: encoder counts since the start and the gyro's turn rate [rad/s]."""
        config, ekf = self._config, self._filter
        left = (ticks[0] - self._ticks[0]) * self._tick / self._period
        right = (ticks[1] - self._ticks[1]) * self._tick / self._period
        self._rest = self._rest + self._period if ticks == self._ticks else 0.0
        self._ticks = ticks
        ekf.predict()
        # A wheel that stands says so more reliably than a rolling one tells its speed.
        resting = self._rest > 0.1
        rolling = abs(left) + abs(right)
        speed_noise = config.rest if resting else config.encoder_floor + config.speed_share * rolling / 2
        turn_noise = config.rest if resting else (config.encoder_floor + config.turn_share * rolling) / self._separation
        noise = np.diag([speed_noise**2, turn_noise**2, config.gyro**2])
        measured = np.array([(left + right) / 2, (right - left) / self._separation, gyro])
        ekf.update(measured, lambda x: self._jacobian, _expected, R=noise)


def _expected(x):
    return np.array([x[SPEED], x[TURN], x[TURN] + x[BIAS]])


class _ArcFilter(ExtendedKalmanFilter):
    """filterpy's filter with the motion model of a differential drive."""

    period: float  # s
    walk: np.ndarray  # (6, 6) covariance of what speed, turn and bias change by in a period

    def predict_x(self, u=0):
        """Second-order (midpoint) integration of the arc; sets the matching Jacobian F and noise Q.

        The speed changes at the start of the period and then moves the robot. So Q ties the change of speed to the way
        made with it, and an encoder reading, which is the mean over that same period, corrects both without lag.
        """
        dt = self.period
        x, y, theta, v, omega, bias = self.x
        middle = theta + omega * dt / 2
        c, s = cos(middle), sin(middle)
        self.x = np.array([x + v * dt * c, y + v * dt * s, theta + omega * dt, v, omega, bias])
        F = np.eye(6)
        F[X, THETA], F[X, SPEED], F[X, TURN] = -v * dt * s, dt * c, -v * dt * dt / 2 * s
        F[Y, THETA], F[Y, SPEED], F[Y, TURN] = v * dt * c, dt * s, v * dt * dt / 2 * c
        F[THETA, TURN] = dt
        self.F, self.Q = F, F @ self.walk @ F.T
