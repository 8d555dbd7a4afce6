import threading

import numpy as np
import pytest

from edge.link.exchange import Inbox
from edge.link.requests import Array, Optimize, OptimizeReply, RequestError
from edge.link.straighten import straighten
from host.service import HostService
from tests.edge.test_robot import make_robot, observation


@pytest.fixture
def robot():
    """Drove 1 m; its first and last node were seen to be 0.8 m apart."""
    robot, _ = make_robot()
    for i in range(11):
        robot.perceive(observation(0.1 * i, x=0.1 * i))
    robot.perceive(observation(1.2, x=1.0))
    first, last = robot.memory.ids[[0, -1]]
    robot.memory.link(first, last, (0.8, 0.0, 0.0), np.eye(3) * 1e6, kind="loop")
    return robot


@pytest.fixture
def host(sessions):
    """``host(optimize)`` serves requests on a thread of its own until the test ends."""
    stop, threads = threading.Event(), []

    def start(optimize):
        inbox = Inbox(sessions[0])
        inbox.on("host/optimize", Optimize, lambda request, exchange: optimize(request))

        def work():
            while not stop.is_set():
                inbox.serve(timeout=0.05)

        threads.append(threading.Thread(target=work))
        threads[-1].start()

    yield start
    stop.set()
    for thread in threads:
        thread.join()


def test_nodes_map_and_robot_move_together(sessions, robot, host):
    host(HostService(None, None, None).optimize)
    wall, here = front(robot), robot.pose[0]
    old, new = straighten(sessions[1], robot)
    after = robot.memory.poses(robot.memory.ids)
    assert np.abs(new - old)[:, 0].max() == pytest.approx(0.2, abs=0.05)
    assert after[-1, 0] - after[0, 0] == pytest.approx(0.8, abs=0.03)
    assert robot.pose[0] < here - 0.05  # with the nodes around it
    assert front(robot) - robot.pose[0] == pytest.approx(wall - here, abs=0.08)  # 2 m
    # The next observation fits the moved map: the robot stays where the graph put it.
    there = robot.pose.copy()
    robot.perceive(observation(1.3, x=1.0))
    np.testing.assert_allclose(robot.pose, there, atol=0.03)


def front(robot):
    """Where the wall ahead of the robot is mapped, x [m]."""
    row, col = robot.grid.frame.to_cell(robot.pose[:2])
    ahead = np.flatnonzero(robot.grid.occupied[row, col:])
    return float(robot.grid.frame.to_world(row, col + ahead[0])[0])


def test_without_a_loop_nobody_is_asked(sessions):
    robot, _ = make_robot()
    robot.perceive(observation(0.0))
    before, after = straighten(sessions[1], robot)
    assert len(before) == len(after) == 0


def test_a_silent_host_changes_nothing(sessions, robot):
    before = robot.memory.poses(robot.memory.ids)
    with pytest.raises(RequestError, match="stays as it is"):
        straighten(sessions[1], robot, timeout=0.3)
    np.testing.assert_array_equal(robot.memory.poses(robot.memory.ids), before)


def test_poses_that_no_map_can_hold_change_nothing(sessions, robot, host):
    def fling(request):
        poses = request.poses.numpy() + np.linspace(0, 1e4, len(request.poses.numpy()))[:, None] * [1, 0, 0]
        return OptimizeReply(Array.of(poses), Array.of(np.repeat(np.eye(3)[None], len(poses), 0)))

    host(fling)
    before, grid = robot.memory.poses(robot.memory.ids), robot.grid.to_bytes()
    with pytest.raises(RequestError, match="stays as it is"):
        straighten(sessions[1], robot)
    np.testing.assert_array_equal(robot.memory.poses(robot.memory.ids), before)
    assert robot.grid.to_bytes() == grid


def test_nonsense_from_a_host_changes_nothing(sessions, robot, host):
    host(lambda request: OptimizeReply(Array.of(np.full((2, 3), np.nan)), Array.of(np.zeros((2, 3, 3)))))
    before = robot.memory.poses(robot.memory.ids)
    with pytest.raises(RequestError, match="stays as it is"):
        straighten(sessions[1], robot)
    np.testing.assert_array_equal(robot.memory.poses(robot.memory.ids), before)
