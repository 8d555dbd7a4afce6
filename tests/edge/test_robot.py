"""What one observation changes in the robot's knowledge."""

import sqlite3
from dataclasses import replace

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.memory.store import Vlpg
from edge.observation import LaserScan, Observation, RgbdFrame
from edge.perception.encoder import View
from edge.robot import Robot
from firmware_sim.pedestrian import Figure


class Counting:
    """An encoder that says the same of every picture and counts them."""

    name, digest, dim = "counting", "0" * 64, 8

    def __init__(self):
        self.pictures = 0

    def encode_image(self, rgb, hfov, window=None):
        self.pictures += 1
        return View(np.eye(4, self.dim, dtype=np.float32), np.zeros(4), None, window)


def make_robot():
    encoder = Counting()
    return Robot(encoder, Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim)), encoder


def observation(stamp, x=0.0, bumper=False, person=None, speed=0.0):
    """From a room, with a ``person`` (x, y) in it whom lidar and camera see."""
    odom = np.array([x, 0.0, 0.0])
    # A room 6 m long and 4 m wide around the odometry's origin.
    angles = -np.pi + np.arange(360) * 2 * np.pi / 360
    cos, sin = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        to_x = np.where(cos > 0, (3 - x) / cos, (-3 - x) / cos)
        to_y = np.where(sin > 0, 2 / sin, -2 / sin)
    ranges = np.minimum(np.abs(to_x), np.abs(to_y)).astype(np.float32)
    depth = np.full((240, 320), np.nan, np.float32)
    if person is not None:
        figure = Figure(*person, 0.25, 1.7)
        ranges = np.minimum(ranges, figure.distances(x, 0.0, np.stack([cos, sin], axis=1))).astype(np.float32)
        depth[:] = 9.0
        camera = CameraModel()
        figure.draw((x + camera.ahead, 0.0, 0.0), camera, np.zeros((240, 320, 3)), depth, np.zeros((240, 320)))
        depth[depth > camera.max_depth] = np.nan
    scan = LaserScan(stamp, ranges, -np.pi, 2 * np.pi / 360, 8.0, odom)
    frame = RgbdFrame(stamp, np.zeros((240, 320, 3), np.uint8), depth, odom)
    return Observation(stamp, odom, np.array([speed, 0.0]), scan, frame, bumper)


def test_standing_still_adds_no_views_and_sharpens_no_walls():
    robot, encoder = make_robot()
    robot.perceive(observation(0.1))
    once, pictures = robot.grid.lidar.copy(), encoder.pictures
    for step in range(2, 12):
        robot.perceive(observation(0.1 * step))
    assert np.array_equal(robot.grid.lidar, once)
    assert encoder.pictures == pictures == 4 and len(robot.memory) == 1


def test_driving_on_adds_both():
    robot, encoder = make_robot()
    for step in range(12):
        robot.perceive(observation(0.1 * step, x=0.06 * step))
    assert encoder.pictures > 8
    assert abs(robot.distance - 0.66) < 0.05
    assert robot.grid.lidar.max() > 1


def test_what_the_whole_picture_shows_to_be_known_is_not_looked_at_closely():
    robot, encoder = make_robot()
    for step in range(8):
        robot.perceive(observation(0.1 * step, x=0.055 * step))
    # A node; a view after 17 cm, where a region might contradict it; views after 28 and 39 cm.
    assert encoder.pictures == 4 + 4 + 1 + 1 and len(robot.memory) == 1


def test_the_bumper_blocks_the_ground_in_front():
    robot, _ = make_robot()
    robot.perceive(observation(0.1))
    ahead = robot.grid.frame.to_cell([robot.config.radius + 0.02, 0.0])
    assert not robot.grid.occupied[ahead]
    robot.perceive(observation(0.2, bumper=True))  # somebody touches a robot that stands
    robot.perceive(observation(0.3, bumper=True, speed=-0.1))
    assert not robot.grid.occupied[ahead]
    robot.perceive(observation(0.4, speed=0.3))
    robot.perceive(observation(0.5, bumper=True))  # it has stopped at once
    assert robot.grid.occupied[robot.grid.frame.to_cell([robot.config.radius + 0.02, 0.0])]
    robot.grid.forget_contacts()
    assert not robot.grid.occupied[robot.grid.frame.to_cell([robot.config.radius + 0.02, 0.0])]


def test_a_lost_robot_does_not_know_what_ground_the_bumper_blocks():
    robot, _ = make_robot()
    robot.perceive(observation(0.1))
    before = robot.grid.to_bytes()
    robot.wake_in(robot.grid)
    robot.perceive(replace(observation(0.2, bumper=True, speed=0.3), scan=None, frame=None))
    assert robot.localizer.lost and robot.grid.to_bytes() == before


def test_the_newest_picture_is_encoded_once_whoever_asks():
    robot, encoder = make_robot()
    robot.perceive(observation(0.1))
    pictures = encoder.pictures
    first = robot.view()
    assert next(robot.look_closely()) is first and encoder.pictures == pictures
    robot.perceive(observation(0.2))
    assert robot.view() is not first and encoder.pictures == pictures + 1


def test_who_walks_by_leaves_no_marks_in_the_map_and_no_view_in_the_memory():
    (alone, pictures), (met, fewer), marks = make_robot(), make_robot(), []
    for step in range(60):
        x = 0.02 * max(0, step - 20)
        walker = (2.0, -0.8 + 0.04 * (step - 20)) if step >= 20 else None
        alone.perceive(observation(0.1 * step, x))
        met.perceive(observation(0.1 * step, x, person=walker))
        x, y = np.abs(met.grid.frame.to_world(*np.nonzero(met.grid.occupied))).T
        marks.append(np.count_nonzero((x < 2.9) & (y < 1.9)))  # not at a wall
    # The lidar may mark who has just come into sight, until they have walked a step; the next turns clear it.
    assert max(marks) < 15 and not any(marks[50:]) and met.grid.depth.max() <= 0
    assert met.movers.anybody and not alone.movers.followed
    assert fewer.pictures < pictures.pictures
    np.testing.assert_allclose(met.pose, (0.78, 0.0, 0.0), atol=0.04)


def test_a_bump_with_a_person_does_not_block_the_ground():
    robot, _ = make_robot()
    for step in range(10):
        robot.perceive(observation(0.1 * step))
    for step in range(10, 20):
        robot.perceive(observation(0.1 * step, person=(0.46, 0.05 * (step - 15)), bumper=step > 15, speed=0.3))
    assert not robot.grid.occupied[robot.grid.frame.to_cell([robot.config.radius + 0.02, 0.0])]


def test_a_full_disk_keeps_the_robot_from_remembering_and_from_nothing_else(monkeypatch):
    robot, _ = make_robot()

    def full(*view):
        raise sqlite3.OperationalError("database or disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(robot.memory, "add", full)
        robot.perceive(observation(0.1))
    assert "disk is full" in robot.forgets and len(robot.memory) == 0 and robot.grid.area > 1
    for step in range(5):
        robot.perceive(observation(0.2 + 0.1 * step, x=0.06 * step))
    assert robot.forgets == "" and len(robot.memory) == 1


def test_a_node_keeps_its_picture():
    robot, _ = make_robot()
    robot.perceive(observation(0.1))
    assert robot.memory.keyframe(0)[:2] == b"\xff\xd8"


def test_a_graph_whose_map_cannot_be_kept_moves_neither(monkeypatch):
    robot, _ = make_robot()
    robot.perceive(observation(0.1))
    robot.memory.flush()
    (node,) = robot.memory.ids
    before, grid = robot.memory.poses([node]), robot.grid

    def full(data):
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr(robot.memory, "_keep_map", full)
    with pytest.raises(sqlite3.OperationalError):
        robot.correct([node], before + [0.3, 0.0, 0.0], np.eye(3)[None])
    np.testing.assert_array_equal(robot.memory.poses([node]), before)
    assert robot.grid is grid
