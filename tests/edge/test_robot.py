"""What one observation changes in the robot's knowledge."""

import numpy as np

from edge.memory.store import Vlpg
from edge.observation import LaserScan, Observation, RgbdFrame
from edge.perception.encoder import View
from edge.robot import Robot


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


def observation(stamp, x=0.0, bumper=False):
    odom = np.array([x, 0.0, 0.0])
    # A room 6 m long and 4 m wide around the odometry's origin.
    angles = -np.pi + np.arange(360) * 2 * np.pi / 360
    cos, sin = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        to_x = np.where(cos > 0, (3 - x) / cos, (-3 - x) / cos)
        to_y = np.where(sin > 0, 2 / sin, -2 / sin)
    ranges = np.minimum(np.abs(to_x), np.abs(to_y)).astype(np.float32)
    scan = LaserScan(stamp, ranges, -np.pi, 2 * np.pi / 360, 8.0, odom)
    frame = RgbdFrame(stamp, np.zeros((240, 320, 3), np.uint8), np.full((240, 320), np.nan, np.float32), odom)
    return Observation(stamp, odom, np.zeros(2), scan, frame, bumper)


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


def test_the_bumper_blocks_the_ground_in_front():
    robot, _ = make_robot()
    robot.perceive(observation(0.1))
    ahead = robot.grid.frame.to_cell([robot.config.radius + 0.02, 0.0])
    assert not robot.grid.occupied[ahead]
    robot.perceive(observation(0.2, bumper=True))
    assert robot.grid.occupied[robot.grid.frame.to_cell([robot.config.radius + 0.02, 0.0])]


def test_a_node_keeps_its_picture():
    robot, _ = make_robot()
    robot.perceive(observation(0.1))
    assert robot.memory.keyframe(0)[:2] == b"\xff\xd8"
