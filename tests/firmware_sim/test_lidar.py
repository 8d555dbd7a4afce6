import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.pose import transform
from firmware_sim.floor_plan import FloorPlan, Room, Wall
from firmware_sim.lidar import Lidar, LidarConfig
from firmware_sim.polygons import edges


class Shell:
    """Just enough of a house: segments and no furniture."""

    objects, revision = {}, 0

    def __init__(self, segments):
        self.segments = segments

    def wall_segments(self):
        return self.segments


def square_room():
    room = Room("room", "Office", [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)])
    walls = [Wall(a, b) for a, b in zip(room.polygon, room.polygon[1:] + room.polygon[:1])]
    return Shell(FloorPlan([room], walls, []).wall_segments)


def test_distances_in_an_empty_room_are_those_of_geometry():
    pose = np.array([2.0, 1.5, 0.7])
    config = LidarConfig()
    ranges = Lidar(square_room(), config, None).scan(pose)
    angles = config.angle_min + np.arange(config.beams) * config.angle_increment + pose[2]
    c, s = np.cos(angles), np.sin(angles)
    to_x = np.where(c > 0, 5.95 - pose[0], 0.05 - pose[0]) / np.where(c == 0, 1e-12, c)
    to_y = np.where(s > 0, 3.95 - pose[1], 0.05 - pose[1]) / np.where(s == 0, 1e-12, s)
    np.testing.assert_allclose(ranges, np.minimum(to_x, to_y), atol=1e-5)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_agrees_with_a_plain_ray_cast_over_random_segments(seed):
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-4, 4, (30, 1, 2))
    segments = middle + rng.uniform(-1, 1, (30, 2, 2))
    pose = rng.uniform(-3, 3, 3)
    config = LidarConfig(beams=90)
    ranges = Lidar(Shell(segments), config, None).scan(pose)
    for beam in range(config.beams):
        angle = config.angle_min + beam * config.angle_increment + pose[2]
        # In the beam's own frame the hit is where a segment crosses the x axis.
        local = transform((0, 0, -angle), (segments - pose[:2]).reshape(-1, 2)).reshape(-1, 2, 2)
        (ax, ay), (bx, by) = local[:, 0].T, local[:, 1].T
        crossing = (ay > 0) != (by > 0)
        x = np.where(crossing, ax + ay / np.where(crossing, ay - by, 1.0) * (bx - ax), np.inf)
        expected = np.min(np.where(x > 0, x, np.inf))
        if expected > config.range_max:
            expected = np.inf
        near_an_end = (np.abs(local[..., 1]) < 1e-6 * np.abs(local[..., 0])).any()
        if not near_an_end:
            assert ranges[beam] == pytest.approx(expected, abs=1e-4)


def test_beyond_its_range_it_sees_nothing():
    far = Shell(edges([[-9, -9], [9, -9], [9, 9], [-9, 9]]))
    assert np.isinf(Lidar(far, LidarConfig(), None).scan((0, 0, 0))).all()
    assert np.isinf(Lidar(Shell(np.zeros((0, 2, 2))), LidarConfig(), None).scan((0, 0, 0))).all()


def test_sees_furniture_at_its_height_and_what_moved(furnished):
    lidar = Lidar(furnished, LidarConfig(), None)
    pose = np.array([5.0, 3.0, 0.0])
    # The shelf hangs at 1.4 m, above the plane: straight up the plan the beam reaches the wall.
    assert lidar.scan(pose)[270] == pytest.approx(0.95, abs=1e-5)
    furnished.move_object("cube-1", 5.0, 3.6, yaw=0.0)
    assert lidar.scan(pose)[270] == pytest.approx(0.4, abs=1e-5)
    # A lamp on a table is above the plane too; the table itself is seen.
    assert lidar.scan((2.3, 2.0, 0.0))[270] == pytest.approx(1.3, abs=1e-5)


def test_raised_things_that_cross_the_plane_are_seen(furnished):
    furnished.add_object("cube-2", "cube", 2.0, 1.0, elevation=0.1)
    assert Lidar(furnished, LidarConfig(), None).scan((1.0, 1.0, 0.0))[180] == pytest.approx(0.8, abs=1e-5)


def test_noise_is_as_stated():
    config = LidarConfig()
    exact = Lidar(square_room(), config, None).scan((2.0, 1.5, 0.7))
    lidar = Lidar(square_room(), config, np.random.default_rng(0))
    errors = np.concatenate([lidar.scan((2.0, 1.5, 0.7)) - exact for _ in range(50)])
    assert errors.std() == pytest.approx(config.noise, rel=0.05)
    assert abs(errors.mean()) < 0.001
