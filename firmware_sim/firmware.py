"""What runs on the base's microcontroller: dead-man's switch, ramps, and a speed controller for each wheel."""

from dataclasses import dataclass
from math import pi

from edge.observation import STOP, Twist


@dataclass(frozen=True)
class FirmwareConfig:
    """Limits and gains; the wheel geometry is the nominal one, what the wheels really measure it does not know."""

    period: float = 0.02  # s; 50 Hz
    command_timeout: float = 0.25  # s; the dead-man's switch
    max_speed: float = 0.6  # m/s
    max_turn: float = 1.5  # rad/s
    acceleration: float = 1.0  # m/s^2; a metre-tall mast must not rock
    deceleration: float = 1.5  # m/s^2; stops from full speed in 0.12 m
    turn_acceleration: float = 6.0  # rad/s^2
    proportional: float = 0.08  # duty per rad/s of error
    integral: float = 1.0  # duty per rad/s and second; proportional / motor lag, which cancels the motor's pole
    motor_lag: float = 0.08  # s; fed forward, so that the wheel keeps up with a ramp
    derivative: float = 0.0006  # duty per rad/s^2
    integral_limit: float = 0.3  # duty; the integral must not wind up against a wall


class WheelPid:
    """Duty of one wheel: feed-forward of the wanted speed and its slope, plus PID with a clamped integral."""

    def __init__(self, config: FirmwareConfig, top_speed: float):
        self._config, self._top_speed = config, top_speed
        self._integral = 0.0
        self._last_speed = self._last_wanted = 0.0

    def update(self, wanted: float, speed: float) -> float:
        """Duty in [-1, 1]. Speeds in rad/s, one call a period."""
        config = self._config
        error = wanted - speed
        step = config.integral * error * config.period
        self._integral = min(max(self._integral + step, -config.integral_limit), config.integral_limit)
        # On the measured speed, not on the error: a new command must not kick.
        damping = config.derivative * (speed - self._last_speed) / config.period
        self._last_speed = speed
        if wanted == 0.0 and abs(speed) < 0.02:
            self._integral = 0.0  # at rest, so that the robot does not creep
        lead = config.motor_lag * (wanted - self._last_wanted) / config.period
        self._last_wanted = wanted
        duty = (wanted + lead) / self._top_speed + config.proportional * error + self._integral - damping
        return min(max(duty, -1.0), 1.0)


class Firmware:
    """Turns the newest velocity command into wheel duties, and stops when commands stop coming."""

    def __init__(self, config: FirmwareConfig, wheel_radius, wheel_separation, ticks_per_turn, top_speed):
        self._config = config
        self._wheel_radius, self._half_track = wheel_radius, wheel_separation / 2
        self._tick = 2 * pi / ticks_per_turn
        self._pids = (WheelPid(config, top_speed), WheelPid(config, top_speed))
        self._ticks = (0, 0)
        self._command, self._command_time = STOP, -float("inf")
        self._v = self._omega = 0.0  # the ramped command

    def command(self, twist: Twist, now: float) -> None:
        """A velocity command arrives at ``now`` [s]; out-of-range values are clamped, NaN counts as a stop."""
        config = self._config
        v, omega = float(twist.v), float(twist.omega)
        if v != v or omega != omega:
            v = omega = 0.0
        v = min(max(v, -config.max_speed), config.max_speed)
        omega = min(max(omega, -config.max_turn), config.max_turn)
        self._command, self._command_time = Twist(v, omega), now

    def update(self, ticks: tuple[int, int], now: float) -> tuple[float, float]:
        """One period: encoder counts in, duties (left, right) out."""
        config = self._config
        # A hair of tolerance: ``now`` is a sum of periods.
        alive = now - self._command_time <= config.command_timeout + 1e-9
        target = self._command if alive else STOP
        self._v = self._ramp(self._v, target.v, config.acceleration, config.deceleration)
        self._omega = self._ramp(self._omega, target.omega, config.turn_acceleration, config.turn_acceleration)
        duties = []
        for side, sign in ((0, -1.0), (1, 1.0)):
            wanted = (self._v + sign * self._omega * self._half_track) / self._wheel_radius
            speed = (ticks[side] - self._ticks[side]) * self._tick / config.period
            duties.append(self._pids[side].update(wanted, speed))
        self._ticks = ticks
        return duties[0], duties[1]

    def _ramp(self, now, target, speeding_up, slowing_down):
        rate = speeding_up if abs(target) > abs(now) and target * now >= 0 else slowing_down
        step = rate * self._config.period
        return min(max(target, now - step), now + step)
