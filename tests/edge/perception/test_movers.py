"""People in a room of known walls, seen by a noisy lidar."""

from dataclasses import replace

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan
from edge.perception.movers import MoverTracker
from firmware_sim.pedestrian import Figure

ANGLES = -np.pi + np.arange(360) * 2 * np.pi / 360


def scan(pose, *figures, stamp=0.0, rng=None):
    """A room 8 m x 6 m around the origin, from ``pose`` (3,), with people in it."""
    x, y, theta = pose
    cos, sin = np.cos(ANGLES + theta), np.sin(ANGLES + theta)
    with np.errstate(divide="ignore"):
        ranges = np.minimum(np.where(cos > 0, 4 - x, -4 - x) / cos, np.where(sin > 0, 3 - y, -3 - y) / sin)
    for figure in figures:
        ranges = np.minimum(ranges, figure.distances(x, y, np.stack([cos, sin], axis=1)))
    if rng is not None:
        ranges = ranges + rng.normal(0, 0.01, 360)
    return LaserScan(stamp, ranges.astype(np.float32), -np.pi, 2 * np.pi / 360, 8.0, np.asarray(pose, float))


def person(x, y):
    return Figure(x, y, 0.25, 1.7)


@pytest.fixture(scope="module")
def grid():
    grid = OccupancyGrid()
    for pose in ((0, 0, 0), (1, 1, 0.3), (-2, -1, 0.1), (2, -2, 1.0), (-3, 2, 0.5)):
        for _ in range(4):
            grid.integrate_scan(np.array(pose, float), scan(pose))
    return grid


def watch(grid, places, pose=(0.0, 0.0, 0.0), tracker=None, start=0.0, speed=0.0):
    """Follow somebody at ``places``, one a scan (None: nobody), from a robot that drives along x at ``speed``."""
    rng, tracker, pose = np.random.default_rng(0), tracker or MoverTracker(), np.array(pose)
    for k, place in enumerate(places):
        figures = [] if place is None else [person(*place)]
        tracker.update(pose, scan(pose, *figures, stamp=start + 0.1 * k, rng=rng), grid)
        pose = pose + [0.1 * speed, 0, 0]
    return tracker


def walk(a, velocity, scans):
    return np.asarray(a) + 0.1 * np.arange(scans)[:, None] * np.asarray(velocity)


@pytest.mark.parametrize("velocity", [(0.0, 0.8), (-0.6, 0.3), (-0.9, -0.7)])
@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_a_walking_person_is_followed(grid, velocity, speed):
    places = walk((2.5, 0.3), velocity, 15)
    (mover,) = watch(grid, places, speed=speed).followed
    np.testing.assert_allclose(mover.position, places[-1], atol=0.08)
    np.testing.assert_allclose(mover.velocity, velocity, atol=0.2)
    assert 0.22 < mover.radius < 0.32 and mover.doubt < 0.25


def test_in_an_empty_room_nobody_moves_whatever_the_robot_does(grid):
    tracker = watch(grid, [None] * 30, speed=0.5)
    assert not tracker.followed and not tracker.anybody and len(tracker.discs) == 0


def test_who_stands_is_new_and_then_part_of_the_home(grid):
    tracker = watch(grid, walk((2.0, 0.5), (0, 0), 4))
    assert len(tracker.discs) == 1 and not tracker.anybody  # it may be about to walk
    doubt = tracker.followed[0].doubt
    tracker = watch(grid, walk((2.0, 0.5), (0, 0), 10), tracker=tracker, start=0.4)
    (mover,) = tracker.followed
    assert len(tracker.discs) == 0 and not mover.velocity.any() and mover.doubt == 0.0 < doubt
    tracker = watch(grid, walk((2.0, 0.5), (0, 0.8), 6), tracker=tracker, start=1.4)
    assert tracker.anybody and len(tracker.discs) == 1 and tracker.followed[0].velocity[1] > 0.4


def test_of_who_has_just_come_the_velocity_is_not_known(grid):
    doubts = [watch(grid, walk((2.0, -1.0), (0, 0.8), scans)).followed[0].doubt for scans in (1, 3, 6, 12)]
    assert doubts[0] > 0.7 and doubts == sorted(doubts, reverse=True) and doubts[-1] < 0.25


def test_out_of_sight_a_person_walks_on_for_a_second(grid):
    tracker = watch(grid, walk((2.0, -1.0), (0, 0.8), 12))
    tracker = watch(grid, [None] * 5, tracker=tracker, start=1.2)
    (mover,) = tracker.followed
    np.testing.assert_allclose(mover.position, (2.0, -1.0 + 0.8 * 1.6), atol=0.2)
    assert not watch(grid, [None] * 8, tracker=tracker, start=1.7).followed


def test_two_people_are_two(grid):
    tracker = MoverTracker()
    for k in range(12):
        figures = person(2.0, -1.5 + 0.07 * k), person(-1.5, 1.5 - 0.07 * k)
        tracker.update(np.zeros(3), scan(np.zeros(3), *figures, stamp=0.1 * k), grid)
    speeds = sorted(mover.velocity[1] for mover in tracker.followed)
    assert speeds == pytest.approx([-0.7, 0.7], abs=0.15)


def test_a_wide_thing_is_nobody(grid):
    tracker = MoverTracker()
    tracker.update(np.zeros(3), scan(np.zeros(3), *(person(2.0, y) for y in np.arange(-1, 1, 0.2))), grid)
    assert not tracker.followed


def test_where_the_pose_is_wrong_nobody_is_seen_though_much_is_where_it_was_not():
    posts = [Figure(1.6 * np.cos(a), 1.6 * np.sin(a), 0.15, 1.7) for a in np.arange(14) * 2 * np.pi / 14]
    grid, seen, tracker = OccupancyGrid(), scan(np.zeros(3), *posts), MoverTracker()
    for pose in ((0, 0, 0), (0.3, 0.2, 0.1), (-0.3, 0.3, 0.2), (0, -0.4, 0.3)):
        for _ in range(4):
            grid.integrate_scan(np.array(pose, float), scan(pose, *posts))
    for shift in ((0.5, 0, 0), (0, 0, 0.22), (-0.3, 0.3, 0)):
        tracker.update(np.array(shift), seen, grid)
        assert not tracker.followed
    tracker.update(np.zeros(3), scan(np.zeros(3), *posts, person(0.8, 0.0), stamp=0.1), grid)
    assert len(tracker.followed) == 1


def test_two_parts_of_a_person_become_one_when_what_was_between_is_seen(grid):
    tracker, standing = MoverTracker(), person(1.3, 0.0)
    for k in range(8):
        seen = scan(np.zeros(3), standing, stamp=0.1 * k)
        ranges = seen.ranges.copy()
        ranges[173:188] = np.nan
        tracker.update(np.zeros(3), seen if k > 5 else replace(seen, ranges=ranges), grid)
        assert len(tracker.followed) == (1 if k > 5 else 2)


def test_only_the_beams_on_who_walks_are_left_out(grid):
    tracker = watch(grid, walk((2.0, -0.6), (0, 0.8), 8))
    newest = scan(np.zeros(3), person(2.0, -0.6 + 0.8 * 0.8), stamp=0.8)
    tracker.update(np.zeros(3), newest, grid)
    cleaned = tracker.without_walkers(newest)
    dropped, empty = np.isnan(cleaned.ranges), scan(np.zeros(3)).ranges
    assert (dropped == (newest.ranges < empty - 0.05)).all() and dropped.sum() > 10
    assert not np.isnan(newest.ranges).any()
    nobody = scan(np.zeros(3), stamp=0.9)
    tracker.update(np.zeros(3), nobody, grid)
    assert tracker.without_walkers(nobody) is nobody


def test_touch_and_hide_know_where_the_person_is(grid):
    tracker = watch(grid, walk((1.0, -0.5), (0, 0.7), 8))
    place = tracker.followed[0].position
    assert tracker.touch(np.array([*(place - (0.45, 0)), 0.0]), 0.18)
    assert not tracker.touch(np.array([*(place - (0.8, 0)), 0.0]), 0.18)
    camera = CameraModel()
    assert tracker.hide(np.zeros(3), camera) and not tracker.hide(np.array([0, 0, np.pi]), camera)
    assert not tracker.hide(np.array([-2.5, 0, 0]), camera)
    assert not tracker.hide(np.array([0, 0, 1.2]), camera)


def test_a_leg_behind_which_a_person_passes_does_not_split_them(grid):
    """The beams that a chair's leg stops are missing from the person, who stays one body."""
    tracker, rng = MoverTracker(), np.random.default_rng(1)
    for k in range(20):
        seen = scan(np.zeros(3), person(2.0, -0.8 + 0.08 * k), stamp=0.1 * k, rng=rng)
        ranges = seen.ranges.copy()
        ranges[178:183] = np.nan
        tracker.update(np.zeros(3), replace(seen, ranges=ranges), grid)
        assert len(tracker.followed) == 1
