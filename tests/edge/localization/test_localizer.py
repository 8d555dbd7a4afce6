from dataclasses import replace

import numpy as np
import pytest

from edge.localization.localizer import Localizer, LocalizerConfig
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan
from edge.pose import between, compose, wrap


def near(got, wanted, distance=0.05, angle=0.02):
    return np.hypot(*(got - wanted)[:2]) < distance and abs(wrap(got[2] - wanted[2])) < angle


def route(count=60):
    """True poses in the boxes home: through the hall and the door to the den, with a turn on the spot."""
    x = np.linspace(2.8, 5.0, count)
    straight = np.stack([x, np.interp(x, [2.8, 3.6, 5.0], [1.6, 2.25, 2.25]), np.full(count, 0.2)], axis=-1)
    spin = np.tile(straight[-1], (30, 1))
    spin[:, 2] += np.linspace(0, 3.0, 30)
    return np.concatenate([straight, spin])


def test_follows_the_odometry_alone():
    localizer = Localizer(np.array([1.0, 2.0, np.pi / 2]))
    got = localizer.update(np.array([0.5, 0.0, 0.1]), None, OccupancyGrid())
    np.testing.assert_allclose(got, [1.0, 2.5, np.pi / 2 + 0.1], atol=1e-12)
    np.testing.assert_allclose(localizer.map_from_odom, [1.0, 2.0, np.pi / 2], atol=1e-12)


def test_corrects_odometry_that_drifts(boxes_map, scan):
    grid, _, lidar = boxes_map
    truth = route()
    localizer = Localizer(truth[0])
    odom = np.zeros(3)
    for last, now in zip(truth, truth[1:]):
        step = between(last, now) * [1.05, 1.0, 1.03] + [0.0, 0.0, 0.001]
        odom = compose(odom, step)
        pose = localizer.update(odom, scan(lidar, now, odom), grid)
        assert near(pose, now)
    assert np.hypot(*(compose(truth[0], odom) - truth[-1])[:2]) > 0.10  # what odometry alone would have said
    np.testing.assert_allclose(compose(localizer.map_from_odom, odom), pose, atol=1e-9)
    assert not localizer.lost and localizer.match.score > 0.9


def test_a_scan_taken_while_turning_is_used_at_its_own_stamp(boxes_map, scan):
    """The scan is two steps (0.3 rad) old when it arrives."""
    grid, _, lidar = boxes_map
    truth = np.array([[2.8, 1.6, 0.15 * i] for i in range(20)])
    localizer = Localizer(truth[0])
    odoms = between(truth[0], truth)
    for i in range(2, 20):
        pose = localizer.update(odoms[i], scan(lidar, truth[i - 2], odoms[i - 2]), grid)
        assert near(pose, truth[i], 0.03, 0.01)


def test_standing_still_matches_nothing(boxes_map, scan):
    grid, _, lidar = boxes_map
    pose = np.array([2.8, 1.6, 0.0])
    localizer = Localizer(pose)
    for _ in range(5):
        localizer.update(np.array([0.01, 0.0, 0.01]), scan(lidar, pose, np.array([0.01, 0.0, 0.01])), grid)
    assert localizer.match is None


def test_a_bad_scan_is_rejected_and_enough_of_them_mean_lost(boxes_map, scan):
    grid, _, lidar = boxes_map
    start = np.array([2.8, 1.6, 0.0])
    localizer = Localizer(start, LocalizerConfig(lost_after=5))
    rng = np.random.default_rng(0)
    for i in range(1, 8):
        odom = np.array([0.06 * i, 0.0, 0.0])
        nonsense = replace(scan(lidar, start, odom), ranges=rng.uniform(0.3, 1.5, 360).astype(np.float32))
        assert localizer.lost == (i > 5)
        pose = localizer.update(odom, nonsense, grid)
        np.testing.assert_allclose(pose, compose(start, odom), atol=1e-9)
    odom = np.array([0.48, 0.0, 0.0])
    good = scan(lidar, compose(start, odom), odom)
    localizer.update(odom, good, grid)
    assert localizer.lost
    assert localizer.relocalize(good, grid) and not localizer.lost


def test_in_an_old_map_it_is_lost_until_it_has_found_its_place(boxes_map, scan):
    grid, _, lidar = boxes_map
    truth, localizer = np.array([2.8, 1.6, 0.0]), Localizer(lost=True)
    for i in range(5):
        odom = np.array([0.06 * i, 0.0, 0.0])
        seen = scan(lidar, compose(truth, odom), odom)
        localizer.update(odom, seen, grid)
        assert localizer.lost and localizer.match is None
    assert localizer.relocalize(seen, grid) and near(localizer.pose(odom), compose(truth, odom))


def test_a_match_far_from_what_odometry_allows_is_rejected(boxes_map, scan):
    grid, _, lidar = boxes_map
    start = np.array([2.8, 1.6, 0.0])
    localizer = Localizer(start)
    elsewhere = start + [0.25, 0.15, 0.1]  # matches well there, but the robot cannot have slipped 0.3 m in one step
    localizer.update(np.array([0.06, 0, 0]), scan(lidar, elsewhere, np.array([0.06, 0, 0])), grid)
    assert localizer.match.score > 0.9 and near(localizer.match.pose, elsewhere)
    np.testing.assert_allclose(localizer.pose(np.array([0.06, 0, 0])), start + [0.06, 0, 0], atol=1e-9)


def test_spinning_wheels_are_noticed(boxes_map, scan):
    """The robot pushes against something: odometry goes on for 0.6 m, the robot stays."""
    grid, _, lidar = boxes_map
    start = np.array([2.8, 1.6, 0.0])
    localizer = Localizer(start)
    for i in range(1, 61):
        odom = np.array([0.01 * i, 0.0, 0.0])
        pose = localizer.update(odom, scan(lidar, start, odom), grid)
        assert np.hypot(*(pose - start)[:2]) < 0.25
    assert near(pose, start, 0.12) and not localizer.lost
    for i in range(1, 6):
        odom = np.array([0.6 + 0.06 * i, 0.0, 0.0])
        pose = localizer.update(odom, scan(lidar, compose(start, [0.06 * i, 0.0, 0.0]), odom), grid)
    assert near(pose, compose(start, [0.30, 0.0, 0.0]))


def test_new_ground_is_not_lost(boxes_map, scan):
    _, _, lidar = boxes_map
    localizer = Localizer(config=LocalizerConfig(lost_after=2))
    for i in range(10):
        odom = np.array([0.1 * i, 0.0, 0.0])
        localizer.update(odom, scan(lidar, np.array([2.0 + 0.1 * i, 1.6, 0.0]), odom), OccupancyGrid())
    assert not localizer.lost
    np.testing.assert_allclose(localizer.map_from_odom, 0, atol=1e-12)


def room_scan(half, odom=(0.0, 0.0, 0.0)):
    """From the middle of a square room whose walls are ``half`` [m] away."""
    angles = -np.pi + np.arange(360) * 2 * np.pi / 360
    ranges = half / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    return LaserScan(0.0, ranges.astype(np.float32), -np.pi, 2 * np.pi / 360, 8.0, np.array(odom))


def test_a_scan_that_contradicts_all_that_is_known_is_no_new_ground():
    """The robot was carried to where everything is near: no return lies on anything mapped."""
    grid = OccupancyGrid()
    for _ in range(3):
        grid.integrate_scan(np.zeros(3), room_scan(3.0))
    localizer = Localizer(config=LocalizerConfig(lost_after=5))
    for i in range(1, 6):
        odom = np.array([0.06 * i, 0.0, 0.0])
        localizer.update(odom, room_scan(0.9, odom), grid)
        assert localizer.match.score == 0.0 and not localizer.fits
    assert localizer.lost


def test_blind_scans_are_survived(boxes_map, scan):
    grid, _, lidar = boxes_map
    localizer = Localizer(np.array([2.8, 1.6, 0.0]))
    seen = scan(lidar, np.array([2.8, 1.6, 0.0]))
    for i, nothing in enumerate((np.nan, np.inf, 0.0), start=1):
        odom = np.array([0.1 * i, 0.0, 0.0])
        blind = replace(seen, ranges=np.full(360, nothing, np.float32), odom=odom)
        assert np.isfinite(localizer.update(odom, blind, grid)).all()
        assert not localizer.relocalize(blind, grid)


@pytest.mark.parametrize("seed", range(6))
def test_relocalizes_in_the_whole_map(boxes_map, scan, seed):
    grid, tour, lidar = boxes_map
    rng = np.random.default_rng(seed)
    rows, cols = np.nonzero(tour.open)
    place = rng.integers(len(rows))
    truth = np.array([*tour.frame.to_world(rows[place], cols[place]), rng.uniform(-np.pi, np.pi)])
    localizer = Localizer(np.array([4.0, 3.0, 0.0]))
    odom = np.array([0.3, 0.2, 1.0])
    assert localizer.relocalize(scan(lidar, truth, odom), grid)
    assert near(localizer.pose(odom), truth)
    assert not localizer.lost


def test_relocalizing_where_nothing_fits_keeps_the_pose(boxes_map, scan):
    grid, _, lidar = boxes_map
    truth = np.array([2.8, 1.6, 0.0])
    localizer = Localizer(truth)
    odd = replace(scan(lidar, truth), ranges=np.random.default_rng(0).uniform(0.3, 3, 360).astype(np.float32))
    assert not localizer.relocalize(odd, grid)
    assert not localizer.relocalize(scan(lidar, truth), OccupancyGrid())
    np.testing.assert_allclose(localizer.pose(np.zeros(3)), truth, atol=1e-12)


@pytest.mark.parametrize("odom", [(30.0, 0.0, 1.0), (-16.0, 25.0, 0.0)])
def test_relocalizes_though_odometry_is_far_outside_the_map(boxes_map, scan, odom):
    grid, _, lidar = boxes_map
    truth, localizer = np.array([2.8, 1.6, 0.0]), Localizer(lost=True)
    assert localizer.relocalize(scan(lidar, truth, np.array(odom)), grid)
    assert near(localizer.pose(np.array(odom)), truth)


def test_two_places_alike_are_no_answer():
    """A square room looks the same after a quarter turn."""
    square = room_scan(1.52)
    grid = OccupancyGrid()
    for _ in range(3):
        grid.integrate_scan(np.zeros(3), square)
    localizer = Localizer(np.array([0.2, 0.1, 0.3]))
    assert not localizer.relocalize(square, grid)
