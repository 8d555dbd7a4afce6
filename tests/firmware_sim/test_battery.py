import pytest

from firmware_sim.battery import Battery, BatteryConfig


def test_drains_by_what_is_drawn():
    battery = Battery(BatteryConfig())
    for _ in range(3600):
        battery.drain(0.0, 1.0)
    # 6 W for an hour at a little under 12 V is half an ampere hour of 5.2.
    assert battery.charge == pytest.approx(1 - 0.5 / 5.2, abs=0.01)


def test_voltage_falls_with_charge_and_load():
    config = BatteryConfig()
    idle, busy = Battery(config), Battery(config)
    idle.drain(0.0, 1.0)
    busy.drain(1.0, 1.0)
    assert busy.voltage < idle.voltage
    for _ in range(10 * 3600):
        busy.drain(1.0, 1.0)
    assert busy.charge == 0.0
    assert 0 < busy.voltage_ratio < 0.9
