"""MPEPC in closed loop with a unicycle whose motors lag, in synthetic rooms."""

from dataclasses import dataclass
from math import hypot, pi

import cv2
import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.perception.movers import Mover
from edge.planning.centring import ImageTarget
from edge.planning.mpepc import Mpepc, MpepcConfig
from edge.planning.theta_star import plan
from edge.planning.trajectory_cost import CostConfig
from edge.pose import between, wrap

CONFIG = MpepcConfig()
FRAME = GridFrame((-1.0, -2.0), 0.05, (120, 160))  # 8 x 6 m


def clearance_of(occupied):
    return cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * np.float32(0.05)


def empty_room():
    occupied = np.zeros(FRAME.shape, bool)
    occupied[[0, -1]] = occupied[:, [0, -1]] = True
    return occupied


def cluttered_room(rng):
    occupied = empty_room()
    for _ in range(12):
        row, col = rng.integers(10, 100), rng.integers(10, 140)
        occupied[row : row + rng.integers(3, 16), col : col + rng.integers(3, 16)] = True
    return occupied


@dataclass
class Unicycle:
    """A first-order motor lag behind each command, integrated at 100 Hz."""

    pose: np.ndarray
    lag: float = 0.08  # s

    def __post_init__(self):
        self.twist = np.zeros(2)

    def advance(self, command):
        for _ in range(10):
            self.twist = self.twist + (1 - np.exp(-0.01 / self.lag)) * (np.array(command) - self.twist)
            v, omega = self.twist
            self.pose = self.pose + 0.01 * np.array([v * np.cos(self.pose[2]), v * np.sin(self.pose[2]), omega])


@dataclass
class Drive:
    """What a closed-loop drive left behind."""

    arrived: bool
    poses: np.ndarray
    commands: np.ndarray
    controller: Mpepc


def drive(occupied, start, goal, heading=None, steps=600, replan=True):
    clearance = clearance_of(occupied)
    controller, robot = Mpepc(CONFIG), Unicycle(np.array(start, float))
    poses, commands, path = [robot.pose], [], None
    for k in range(steps):
        if path is None or (replan and k % 10 == 0):
            path = np.array([start[:2], goal])
            if replan:
                path = plan(clearance > 0.25, FRAME, robot.pose[:2], goal, clearance)
        command = controller.step(robot.pose, robot.twist, path, clearance, FRAME, goal_heading=heading)
        commands.append((command.v, command.omega))
        if controller.arrived:
            break
        robot.advance(commands[-1])
        poses.append(robot.pose)
    return Drive(controller.arrived, np.array(poses), np.array(commands), controller)


def assert_within_limits(commands):
    law = CONFIG.law
    assert (np.abs(commands[:, 0]) <= law.v_max + 1e-9).all()
    assert (np.abs(commands[:, 1]) <= law.omega_max + 1e-9).all()
    change = np.abs(np.diff(commands, axis=0, prepend=[[0, 0]]))
    assert (change[:, 0] <= law.acceleration * CONFIG.period + 0.151).all()  # 0.15: measured speed


@pytest.mark.parametrize("seed", [0, 1, 4])
def test_reaches_pose_in_cluttered_room_without_touching_anything(seed):
    rng = np.random.default_rng(seed)
    occupied = cluttered_room(rng)
    clearance = clearance_of(occupied)
    cells = np.argwhere(clearance > 0.25)
    path = None
    while path is None or np.hypot(*(path[-1] - path[0])) < 3:
        start, goal = (FRAME.to_world(*cell) for cell in cells[rng.integers(len(cells), size=2)])
        path = plan(clearance > 0.25, FRAME, start, goal, clearance)
    heading = rng.uniform(-pi, pi)
    result = drive(occupied, [*start, rng.uniform(-pi, pi)], goal, heading)
    assert result.arrived
    assert hypot(*(result.poses[-1, :2] - goal)) < 0.10
    assert abs(wrap(result.poses[-1, 2] - heading)) < np.radians(5)
    assert_within_limits(result.commands)
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    assert len(result.commands) * 0.1 < 6 + length / 0.3
    solid = FRAME.to_world(*np.nonzero(occupied))
    gap = min(np.abs(solid - xy).max(axis=1).min() for xy in result.poses[::3, :2])  # to the nearest cell's centre
    nearest = min(np.hypot(*np.maximum(np.abs(solid - xy) - 0.025, 0).T).min() for xy in result.poses[::2, :2])
    assert gap > 0 and nearest > CONFIG.cost.radius
    assert np.abs(np.diff(result.commands[:, 1])).mean() < 0.12  # smooth: rad/s between commands


@pytest.mark.parametrize("turn", [pi / 2, -3.0, 0.2])
def test_turns_on_the_spot_at_the_goal(turn):
    result = drive(empty_room(), [1.0, 1.0, 0.0], np.array([1.0, 1.0]), turn)
    assert result.arrived
    assert abs(wrap(result.poses[-1, 2] - turn)) < np.radians(5)
    assert np.hypot(*(result.poses[:, :2] - [1.0, 1.0]).T).max() < 0.05
    assert len(result.commands) < 60


def test_turns_round_for_a_goal_behind():
    result = drive(empty_room(), [4.0, 1.0, 0.0], np.array([1.0, 1.0]))
    assert result.arrived
    assert result.poses[:, 0].max() < 4.2
    assert len(result.commands) * 0.1 < 14


def test_drives_fast_where_there_is_room():
    result = drive(empty_room(), [0.0, 1.0, 0.0], np.array([6.0, 1.0]))
    assert result.commands[:, 0].max() > 0.55
    assert len(result.commands) * 0.1 < 15


def test_stops_before_a_wall_that_the_path_ignores():
    occupied = empty_room()
    occupied[:, 80:82] = True
    result = drive(occupied, [0.5, 1.0, 0.0], np.array([5.0, 1.0]), steps=130, replan=False)
    wall = FRAME.to_world(0, 80)[0] - 0.025
    assert result.poses[:, 0].max() < wall - CONFIG.cost.radius
    assert not result.arrived
    assert np.abs(result.commands[-20:, 0]).max() < 0.03
    assert result.controller.stalled > 1.0


def test_brakes_gently_unless_somebody_comes():
    clearance, here = clearance_of(empty_room()), np.array([1.0, 1.0, 0.0])
    path = np.array([[0.5, 1.0], [1.05, 1.0]])  # it has all but passed its end
    measured, believed = 0.65, 0.5  # a controller that has commanded nothing yet believes a speed short of 0.15 m/s
    alone = Mpepc().step(here, [measured, 0.0], path, clearance, FRAME)
    person = Mover(np.array([1.9, 1.0]), np.array([-1.2, 0.0]), 0.1, 0.25)
    met = Mpepc().step(here, [measured, 0.0], path, clearance, FRAME, movers=[person])
    step = CONFIG.period
    assert believed - alone.v <= step * CONFIG.law.acceleration + 1e-9
    assert step * CONFIG.law.acceleration + 0.01 < believed - met.v <= step * CONFIG.law.brake + 1e-9


def test_brakes_along_its_arc_when_even_the_best_trajectory_collides():
    occupied = empty_room()
    occupied[:, 80:82] = True
    careless = MpepcConfig(cost=CostConfig(collision=0.0, acceleration_weight=10.0))  # loath to brake
    controller, here = Mpepc(careless), np.array([FRAME.to_world(0, 80)[0] - 0.4, 1.0, 0.0])
    path = np.array([[0.5, 1.0], [5.0, 1.0]])
    speeds = [0.6]
    for _ in range(2):
        command = controller.step(here, [speeds[-1], 0.0], path, clearance_of(occupied), FRAME)
        speeds.append(command.v)
    assert speeds[2] <= speeds[1] - 0.079


def test_gets_away_from_an_obstacle_that_is_nearer_than_the_margin():
    occupied = empty_room()
    start = np.array([FRAME.to_world(0, 1)[0] + 0.18, 1.0, pi / 2])
    result = drive(occupied, start, np.array([3.0, 2.0]))
    assert result.arrived


def test_backs_off_when_the_bumper_is_hit_and_stops_for_a_wall_behind():
    clearance = clearance_of(empty_room())
    path = np.array([[1.0, 1.0], [3.0, 1.0]])
    controller = Mpepc()
    twist = controller.step([1.0, 1.0, 0.0], [0.0, 0.0], path, clearance, FRAME, bumper=True)
    assert twist.v == -CONFIG.back_speed
    steps = 1
    while controller.step([1.0, 1.0, 0.0], [-0.1, 0.0], path, clearance, FRAME).v == -CONFIG.back_speed:
        steps += 1
    assert steps == 8
    wall = FRAME.to_world(0, 1)[0]
    assert Mpepc().step([wall + 0.2, 1.0, 0.0], [0.0, 0.0], path, clearance, FRAME, bumper=True).v == 0.0


def test_same_inputs_give_the_same_commands():
    room = cluttered_room(np.random.default_rng(7))
    runs = [drive(room, [-0.6, -1.6, 0.0], np.array([6.0, 3.0]), steps=40) for _ in range(2)]
    np.testing.assert_array_equal(runs[0].commands, runs[1].commands)


def test_new_goal_is_not_reached_yet():
    clearance, here = clearance_of(empty_room()), np.array([1.0, 1.0, 0.0])
    controller = Mpepc()
    controller.step(here, [0, 0], np.array([[1.0, 1.0], [1.0, 1.0]]), clearance, FRAME)
    assert controller.arrived
    controller.step(here, [0, 0], np.array([[1.0, 1.0], [2.0, 1.0]]), clearance, FRAME)
    assert not controller.arrived
    controller.step(here, [0, 0], np.array([[1.0, 1.0], [1.0, 1.0]]), clearance, FRAME, goal_heading=1.0)
    assert not controller.arrived


def test_needs_something_to_drive_to():
    with pytest.raises(ValueError, match="path or a target"):
        Mpepc().step(np.zeros(3), [0, 0], None, clearance_of(empty_room()), FRAME)


def approach(occupied, start, thing, steps=200):
    """Drive to a still object seen by a perfect camera; returns the poses, pixel errors, depths and the controller."""
    camera, clearance = CameraModel(), clearance_of(occupied)
    controller, robot = Mpepc(CONFIG, camera), Unicycle(np.array(start, float))
    errors, depths, poses = [], [], []
    for _ in range(steps):
        x, y, _ = between(robot.pose, [*thing, 0.0])
        u, _, depth = (float(value[0]) for value in camera.project([[x, y, 0.5]]))
        errors.append(u - camera.centre[0])
        depths.append(depth)
        poses.append(robot.pose)
        command = controller.step(robot.pose, robot.twist, None, clearance, FRAME, target=ImageTarget(u, depth))
        if controller.arrived:
            break
        robot.advance((command.v, command.omega))
    return np.array(poses), np.array(errors), np.array(depths), controller


@pytest.mark.parametrize("heading", [0.0, 0.5, -0.55])
def test_centres_and_approaches_an_object(heading):
    _, errors, depths, controller = approach(empty_room(), [0.5, 1.0, heading], (5.0, 1.0))
    assert controller.arrived
    assert depths[-1] == pytest.approx(CONFIG.centring.depth, abs=0.12)
    assert abs(errors[-1]) < 8
    assert np.abs(errors).max() <= abs(errors[0]) + 12  # never further out of the picture than at first
    assert np.abs(errors[len(errors) // 2 :]).max() < 15


def test_centres_from_where_it_stands_when_the_way_to_the_object_is_blocked():
    occupied = empty_room()
    occupied[:, 80:90] = True  # a table's edge at x = 3
    poses, errors, depths, controller = approach(occupied, [1.0, 1.0, 0.4], (5.0, 1.0))
    assert controller.arrived
    assert abs(errors[-1]) < 8 and depths[-1] > 1.5
    assert poses[:, 0].max() < 3.0 - CONFIG.cost.radius


def test_turns_towards_an_object_that_is_too_near():
    poses, errors, _, controller = approach(empty_room(), [3.0, 1.0, 0.5], (3.9, 1.0))
    assert controller.arrived and abs(errors[-1]) < 8
    assert np.hypot(*(poses[-1, :2] - poses[0, :2])) < 0.15
