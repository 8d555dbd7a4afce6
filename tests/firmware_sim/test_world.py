import numpy as np
import pytest

from edge.observation import Twist
from edge.pose import between, compose
from firmware_sim.house import House
from firmware_sim.placement import HouseError
from firmware_sim.world import World, WorldConfig

BLIND = WorldConfig(camera=False)


def tour(world, steps=300):
    """Legs of 1.1 m and quarter turns to the left."""
    ahead, turn = Twist(0.4, 0.0), Twist(0.0, 1.0)
    return [world.step(ahead if i % 60 < 28 else turn if i % 60 < 44 else None) for i in range(steps)]


def test_the_same_seed_gives_the_same_trajectory(furnished):
    runs = []
    for seed in (3, 3, 4):
        world = World(furnished, seed, BLIND)
        last = tour(world)[-1]
        runs.append(np.concatenate([world.truth, last.odom, last.scan.ranges]))
    np.testing.assert_array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


def test_observations_are_stamped_and_scans_come_at_10_hz(empty):
    world = World(empty, 0, BLIND)
    seen = [world.step(None, dt=0.02) for _ in range(50)]
    assert [round(o.stamp, 6) for o in seen] == [round(0.02 * i, 6) for i in range(1, 51)]
    scans = [o.scan for o in seen if o.scan is not None]
    assert len(scans) == 10
    assert np.diff([scan.stamp for scan in scans]) == pytest.approx(0.1)
    assert all(o.frame is None for o in seen)


def test_odom_starts_at_zero_and_follows_the_truth_without_noise(empty):
    world = World(empty, 0, WorldConfig(camera=False, noise=False))
    np.testing.assert_allclose(world.step(None).odom, 0.0, atol=1e-6)
    last = tour(world)[-1]
    error = between(world.truth, compose(empty.start, last.odom))
    assert np.hypot(*error[:2]) < 0.03
    assert abs(error[2]) < 0.01


def test_odom_drifts_with_noise_as_a_cheap_base_would(empty):
    errors = []
    for seed in range(4):
        world = World(empty, seed, BLIND)
        last = tour(world, 360)[-1]
        errors.append(between(world.truth, compose(empty.start, last.odom)))
    distance = np.hypot(*np.array(errors)[:, :2].T)
    heading = np.abs(np.degrees(np.array(errors)[:, 2]))
    # 7 m and six quarter turns: some centimetres, a degree or two.
    assert 0.005 < distance.mean() < 0.2
    assert 0.05 < heading.mean() < 3.0


def test_no_command_means_the_dead_mans_switch(empty):
    world = World(empty, 0, BLIND)
    for _ in range(10):
        world.step(Twist(0.5, 0.0))
    for _ in range(10):
        world.step(None)
    x = world.truth[0]
    for _ in range(10):
        world.step(None)
    assert world.truth[0] == pytest.approx(x, abs=1e-3)


def test_bumper_and_contacts_tell_of_a_collision(empty):
    world = World(empty, 0, BLIND)
    seen = [world.step(Twist(0.5, 0.0)) for _ in range(10)]
    assert world.contacts == 0 and not any(o.bumper for o in seen)
    world = World(empty, 0, BLIND, start=(1.0, 3.4, np.pi / 2))
    seen = [world.step(Twist(0.5, 0.0)) for _ in range(20)]
    assert world.contacts == 1 and seen[-1].bumper


def test_a_moved_object_is_seen_and_felt(furnished):
    world = World(furnished, 0, WorldConfig(camera=False, noise=False))
    ahead = world.step(None).scan.ranges[180]
    furnished.move_object("cube-1", 2.0, 2.0, yaw=0.0)
    assert ahead > 5.0
    assert world.step(None).scan.ranges[180] == pytest.approx(0.8, abs=0.01)
    for _ in range(60):
        world.step(Twist(0.4, 0.0))
    assert world.contacts >= 1
    assert world.truth[0] < 1.65


def test_battery_drains_and_imu_feels_the_turn(empty):
    world = World(empty, 0, BLIND)
    charge = world.battery.charge
    for _ in range(20):
        world.step(Twist(0.0, 1.0))
    assert world.battery.charge < charge
    assert world.imu.turn_rate == pytest.approx(1.0, abs=0.1)


def test_a_step_must_be_a_multiple_of_the_firmwares_period(empty):
    with pytest.raises(ValueError, match="multiple"):
        World(empty, 0, BLIND).step(None, dt=0.05 / 3)


@pytest.fixture(scope="module")
def cottage():
    return House.load("cottage")


def test_pictures_come_at_10_hz_with_the_scan(cottage):
    world = World(cottage, 0)
    seen = [world.step(None, dt=0.02) for _ in range(10)]
    frames = [o.frame for o in seen if o.frame is not None]
    assert [frame.stamp for frame in frames] == [o.scan.stamp for o in seen if o.scan is not None]
    assert len(frames) == 2 and frames[0].rgb.shape == (240, 320, 3) and frames[0].depth.shape == (240, 320)


def test_visible_fraction_counts_what_is_in_view_and_not_hidden(cottage):
    # At the foot of the bed, looking over it; the piano is two rooms away behind walls.
    for camera in (True, False):
        world = World(cottage, 0, WorldConfig(camera=camera), start=(2.6, 5.2, 1.9))
        world.step(None)
        assert world.visible_fraction("teddy-bear-1") > 0.95
        assert 0.02 < world.visible_fraction("bed2-1") < 0.6
        assert world.visible_fraction("piano-aqueue-1") == 0.0
    with pytest.raises(HouseError, match="no object 'ghost'"):
        world.visible_fraction("ghost")


def test_visible_fraction_falls_when_something_is_put_in_front():
    house = House.load("cottage")
    world = World(house, 0, start=(2.8, 1.9, 0.1))
    world.step(None)
    before = world.visible_fraction("decorative-plant-1"), world.visible_fraction("thonet-1")
    house.add_object("occluder", "high-cabinet", 4.25, 2.0, -np.pi / 2)
    after = world.visible_fraction("decorative-plant-1"), world.visible_fraction("thonet-1")
    assert before[1] > 0.8 and after[1] == 0.0
    assert after[0] == pytest.approx(before[0], abs=0.02)
    assert world.visible_fraction("occluder") > 0.2
