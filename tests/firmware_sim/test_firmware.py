import numpy as np
import pytest

from edge.observation import STOP, Twist
from firmware_sim.base import Base, BaseConfig
from firmware_sim.firmware import Firmware, FirmwareConfig


class Rig:
    """Base and firmware alone, 50 Hz."""

    def __init__(self, house):
        config = BaseConfig()
        self.base = Base(house, house.start, config, None)
        self.firmware = Firmware(
            FirmwareConfig(), config.wheel_radius, config.wheel_separation, config.ticks_per_turn, config.top_speed
        )
        self.time = 0.0

    def run(self, seconds, twist=None):
        """The forward speed after each period; ``twist`` is sent every 100 ms."""
        speeds = []
        for i in range(round(seconds / 0.02)):
            if twist is not None and i % 5 == 0:
                self.firmware.command(twist, self.time)
            self.base.advance(self.firmware.update(self.base.ticks, self.time), 2)
            self.time += 0.02
            speeds.append(self.base.twist[0])
        return np.array(speeds)


@pytest.mark.parametrize("v, omega", [(0.3, 0.0), (0.1, 0.5), (-0.2, 0.0), (0.0, 1.2)])
def test_reaches_and_holds_the_commanded_velocity(empty, v, omega):
    rig = Rig(empty)
    rig.run(2.0, Twist(v, omega))
    assert rig.base.twist == pytest.approx((v, omega), abs=0.02)


def test_speed_neither_overshoots_much_nor_ramps_too_fast(empty):
    speeds = Rig(empty).run(2.0, Twist(0.5, 0.0))
    assert speeds.max() < 0.55
    assert np.diff(speeds).mean() / 0.02 < 1.1
    assert (speeds[10:24] - speeds[:14]).max() / 0.2 < 1.15


def test_stops_when_commands_stop_coming(empty):
    rig = Rig(empty)
    rig.run(1.0, Twist(0.5, 0.0))
    silence = rig.run(1.0)
    # The last command came 80 ms before; 250 ms after it the brakes go on.
    assert silence[7] == pytest.approx(0.5, abs=0.03)
    assert silence[12] < 0.45
    assert abs(silence[35:]).max() < 0.02
    x = rig.base.pose[0]
    rig.run(5.0)
    assert rig.base.pose[0] == pytest.approx(x, abs=1e-3)


def test_absurd_commands_are_clamped_and_nan_stops(empty):
    rig = Rig(empty)
    assert rig.run(1.5, Twist(50.0, 0.0))[-1] == pytest.approx(0.6, abs=0.02)
    assert abs(rig.run(1.5, Twist(float("nan"), 0.0))[-1]) < 0.02


def test_stop_command_stops_within_braking_distance(empty):
    rig = Rig(empty)
    rig.run(1.5, Twist(0.6, 0.0))
    x = rig.base.pose[0]
    rig.run(1.0, STOP)
    assert 0.08 < rig.base.pose[0] - x < 0.25
