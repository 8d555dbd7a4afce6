import numpy as np
import pytest

from edge.pose import between
from firmware_sim.base import Base, BaseConfig
from firmware_sim.polygons import distance_to_segments, edges


def drive(base, duties, seconds):
    base.advance(duties, round(seconds / 0.01))
    return base.pose


def test_drives_straight_as_far_as_its_wheels_turn(empty):
    base = Base(empty, (1.0, 2.0, 0.0), BaseConfig(), None)
    x, y, theta = drive(base, (0.3, 0.3), 3.0)
    rolled = np.array(base.ticks) * 2 * np.pi / 2048 * 0.05
    assert rolled[0] == pytest.approx(x - 1.0, abs=0.01)
    assert (y, theta) == pytest.approx((2.0, 0.0))


def test_runs_the_circle_of_its_wheel_speeds(empty):
    base = Base(empty, (2.0, 1.2, 0.0), BaseConfig(), None)
    drive(base, (0.1, 0.4), 1.0)
    v, omega = base.twist
    assert v / omega == pytest.approx(0.28 / 2 * (0.4 + 0.1) / (0.4 - 0.1), rel=0.01)
    before = base.pose
    after = drive(base, (0.1, 0.4), 1.0)
    turned = after[2] - before[2]
    chord = 2 * v / omega * np.sin(turned / 2)
    forward, left, _ = between(before, after)
    np.testing.assert_allclose([forward, left], chord * np.array([np.cos(turned / 2), np.sin(turned / 2)]), atol=2e-3)


def test_a_wall_stops_it_and_is_felt(empty):
    base = Base(empty, (1.0, 0.8, -np.pi / 2), BaseConfig(), None)
    x, y, _ = drive(base, (0.5, 0.5), 4.0)
    assert base.touching and len(base.contacts) == 1
    assert y == pytest.approx(0.05 + 0.18, abs=0.01)


def test_furniture_stops_it_until_it_is_moved_away(furnished):
    start = (5.0, 1.0, 0.0)
    base = Base(furnished, start, BaseConfig(), None)
    gaps = []
    for _ in range(40):
        drive(base, (0.4, 0.4), 0.1)
        gaps.append(distance_to_segments(base.pose[:2], edges(furnished.objects["cube-1"].footprint)))
    assert min(gaps) == pytest.approx(0.18, abs=0.01)
    assert len(base.contacts) >= 1
    furnished.move_object("cube-1", 4.5, 3.5)
    base = Base(furnished, start, BaseConfig(), None)
    assert drive(base, (0.4, 0.4), 2.0)[0] > 5.6
    furnished.move_object("cube-1", 6.5, 1.0, yaw=0.0)
    assert drive(base, (0.4, 0.4), 3.0)[0] == pytest.approx(6.3 - 0.18, abs=0.02)


def test_what_hangs_high_or_stands_on_furniture_is_no_obstacle(furnished):
    base = Base(furnished, (5.5, 2.8, np.pi / 2), BaseConfig(), None)
    assert drive(base, (0.4, 0.4), 4.0)[1] == pytest.approx(3.95 - 0.18, abs=0.01)


def test_slip_makes_wheels_and_way_disagree_but_not_by_much(empty):
    base = Base(empty, (1.0, 2.0, 0.0), BaseConfig(), np.random.default_rng(1))
    x, y, theta = drive(base, (0.3, 0.3), 3.0)
    rolled = np.mean(base.ticks) * 2 * np.pi / 2048 * 0.05
    assert 1e-4 < abs(rolled - (x - 1.0)) < 0.05
    assert 1e-4 < abs(theta) < 0.1
