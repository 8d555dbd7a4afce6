"""A person in the house: where they walk, what the lidar and the camera see of them, and what the robot feels."""

from math import pi

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.observation import Twist
from edge.pose import transform
from firmware_sim.house import House
from firmware_sim.lidar import LidarConfig
from firmware_sim.pedestrian import Figure, Pedestrian
from firmware_sim.world import World, WorldConfig

QUIET = WorldConfig(camera=False, noise=False)


def standing(x, y):
    """A person who is about to leave, for a long time."""
    return Pedestrian(np.array([[x, y], [x + 1, y]]), 1.0, departure=1e6)


def test_walks_the_polyline_at_its_speed_and_stands_at_the_ends():
    person = Pedestrian(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]]), 0.5, departure=2.0)
    for time, place in ((0, (0, 0)), (2, (0, 0)), (4, (1, 0)), (8, (3, 0)), (12, (3, 2)), (99, (3, 4))):
        np.testing.assert_allclose(person.position(time), place, atol=1e-12)


@pytest.mark.parametrize("waypoints, speed", [([[0.0, 0.0]], 1.0), ([[0.0, 0.0], [1.0, 0.0]], 0.0)])
def test_nobody_walks_without_a_way_or_a_speed(waypoints, speed):
    with pytest.raises(ValueError, match="two waypoints"):
        Pedestrian(np.array(waypoints), speed)


def test_distances_end_on_the_cylinder():
    figure = Figure(2.0, 1.0, 0.25, 1.7)
    angles = np.linspace(0, 2 * pi, 721)
    beams = np.stack([np.cos(angles), np.sin(angles)], axis=1) * 1.3
    times = figure.distances(-0.5, 0.2, beams)
    hit = np.isfinite(times)
    ends = np.array([-0.5, 0.2]) + times[hit, None] * beams[hit]
    np.testing.assert_allclose(np.hypot(*(ends - (2.0, 1.0)).T), 0.25, atol=1e-9)
    # As wide as a cylinder of that radius looks from there, and only ahead.
    assert hit.sum() / 720 * 2 * pi == pytest.approx(2 * np.arcsin(0.25 / np.hypot(2.5, 0.8)), abs=0.02)
    assert (ends @ (2.5, 0.8) > 0).all()


def test_the_lidar_and_the_depth_picture_see_the_person_in_the_same_place():
    house = House.load("cottage")
    world = World(house, 0, WorldConfig(noise=False), start=(2.8, 1.9, 0.1))
    before = world.step(None)
    x, y, theta = world.truth
    place = np.array([x + 1.5 * np.cos(theta + 0.2), y + 1.5 * np.sin(theta + 0.2)])
    world.admit(standing(*place))
    seen = world.step(None)
    nearer = np.flatnonzero(seen.scan.ranges < before.scan.ranges - 0.2)
    angles = seen.scan.angle_min + seen.scan.angle_increment * nearer
    returns = seen.scan.ranges[nearer, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    np.testing.assert_allclose(np.hypot(*(transform(world.truth, returns) - place).T), 0.25, atol=0.005)

    changed = np.abs(seen.frame.depth - before.frame.depth) > 0.2
    model = CameraModel()
    row, column = np.nonzero(changed & (seen.frame.depth > 0))
    points = model.unproject(column, row, seen.frame.depth[row, column])
    assert len(points) > 3000
    away = np.hypot(*(transform(world.truth, points[:, :2]) - place).T)
    np.testing.assert_allclose(away, 0.25, atol=0.01)
    assert points[:, 2].min() >= 0 and points[:, 2].max() <= 1.7 and points[:, 2].max() > 1.6
    assert (seen.frame.rgb[row, column] != before.frame.rgb[row, column]).any(axis=1).mean() > 0.9
    assert (world.picture.instances[row, column] == -1).all()


def test_what_stands_in_front_of_the_person_hides_them():
    figure, model = Figure(3.0, 0.0, 0.25, 1.7), CameraModel()
    rgb, instances = np.zeros((240, 320, 3), np.uint8), np.full((240, 320), 7, np.int16)
    depth = np.full((240, 320), 5.0, np.float32)
    depth[:, 160:] = 2.0
    figure.draw((0.0, 0.0, 0.0), model, rgb, depth, instances)
    assert (depth[:, 160:] == 2.0).all() and (instances[:, 160:] == 7).all()
    assert depth[120, 158] == pytest.approx(2.75, abs=0.01) and instances[120, 158] == -1


def test_a_person_hides_what_is_behind_from_the_judge_too():
    world = World(House.load("cottage"), 0, QUIET, start=(2.6, 5.2, 1.9))
    world.step(None)
    assert world.visible_fraction("teddy-bear-1") > 0.95
    x, y, _ = world.truth
    teddy = world.house.objects["teddy-bear-1"]
    line = np.array([teddy.x - x, teddy.y - y])
    world.admit(standing(*(np.array([x, y]) + 0.7 * line / np.hypot(*line))))
    assert world.visible_fraction("teddy-bear-1") < 0.3


def test_a_contact_tells_who_was_met_and_whether_the_robot_drove(empty):
    driving = World(empty, 0, QUIET)
    driving.admit(standing(2.0, 2.0))
    bumped = any(driving.step(Twist(0.4, 0.0)).bumper for _ in range(25))
    (contact,) = driving.base.contacts
    assert bumped and driving.contacts == 1 and contact.person and contact.speed > 0.3
    waiting = World(empty, 0, QUIET)
    waiting.admit(Pedestrian(np.array([[3.0, 2.0], [1.1, 2.0]]), 1.0))
    for _ in range(25):
        waiting.step(None)
    (contact,) = waiting.base.contacts
    assert contact.person and contact.speed < 0.01
    assert waiting.truth[0] < 0.9  # pushed
    wall = World(empty, 0, QUIET, start=(1.0, 3.4, pi / 2))
    wall.admit(standing(3.0, 1.0))
    for _ in range(20):
        wall.step(Twist(0.5, 0.0))
    assert [contact.person for contact in wall.base.contacts] == [False]


def test_an_empty_house_is_as_before_and_people_change_no_other_noise(empty):
    alone, visited = (World(empty, 5, WorldConfig(camera=False)) for _ in range(2))
    visited.admit(standing(3.0, 1.0))
    for _ in range(10):
        a, b = alone.step(Twist(0.2, 0.3)), visited.step(Twist(0.2, 0.3))
        np.testing.assert_array_equal(a.odom, b.odom)
        same = a.scan.ranges == b.scan.ranges
        assert 0 < (~same).sum() < 40
    assert len(a.scan.ranges) == LidarConfig().beams
