"""A node with a robot and missions that are as simple as can be, and a base that publishes at the pace of the test."""

import threading
import time
from types import SimpleNamespace

import numpy as np

from edge.camera import CameraModel
from edge.link import messages, requests
from edge.link.conversions import (
    camera_to_message,
    color_to_message,
    depth_to_message,
    odometry_to_message,
    scan_to_message,
    twist_from_message,
)
from edge.link.exchange import NoAnswer, ask
from edge.link.messages import decode, encode
from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg
from edge.node import Missions, Node, NodeConfig
from edge.observation import STOP, LaserScan, Twist
from edge.planning.local_search import Replan
from edge.service import Service

CAMERA = CameraModel(width=32, height=24)


class FakeRobot:
    """Believes odometry, and has room for what the node reports."""

    def __init__(self):
        self.encoder = SimpleNamespace(name="tower", digest="abc", dim=4, mode="auto")
        self.memory = Vlpg.open(":memory:", "tower", "abc", 4)
        self.camera, self.grid = CameraModel(), OccupancyGrid()
        self.coverage = SimpleNamespace(viewed=np.zeros((0, 0), np.uint8))
        self.stamp, self.pose, self.distance = 0.0, np.zeros(3), 0.0
        self.localizer = SimpleNamespace(lost=False)
        self.forgets, self.observations = "", []

    def wake_in(self, grid):
        self.grid, self.localizer.lost = grid, True

    def perceive(self, observation):
        self.observations.append(observation)
        self.stamp, self.pose = observation.stamp, observation.odom
        if observation.scan is not None:
            self.grid.integrate_scan(self.pose, observation.scan)


class Drive:
    """Drives for ``steps`` control steps, then ends with ``outcome``."""

    def __init__(self, robot, steps, outcome, breaks=False):
        self.robot, self.steps, self.ends_with, self.breaks = robot, steps, outcome, breaks
        self.outcome = None

    @property
    def done(self):
        return self.outcome is not None

    def step(self, observation):
        self.robot.perceive(observation)
        if self.breaks:
            raise ZeroDivisionError("the planner divided by zero")
        self.steps -= 1
        if self.steps <= 0:
            self.outcome = self.ends_with
            return STOP
        return Twist(0.2, 0.1)


def mapped(complete=True):
    return SimpleNamespace(complete=complete, duration=9.0, distance=4.0)


def found(robot):
    sighting = SimpleNamespace(
        position=np.array([1.0, 2.0]),
        bearing=0.1,
        depth=1.5,
        detection=SimpleNamespace(score=0.9, box=(1.0, 2.0, 3.0, 4.0)),
    )
    place = SimpleNamespace(pose=np.array([1.0, 0.0, 0.5]), score=0.8, members=np.array([1, 0]))
    return SimpleNamespace(
        status="found",
        hypotheses=[place],
        places=np.array([[1.0, 0.0, 0.5], [1.1, 0.0, 0.6]]),
        claim=SimpleNamespace(sighting=sighting),
        confidence=0.7,
        duration=12.0,
        distance=3.0,
        replans=[Replan(GridFrame((-1.0, 0.5), 0.05, (2, 2)), np.array([[0, 1], [0.1, 0.2]]), np.array([1.0, 0, 0]))],
    )


class Rig:
    """A node in a thread, and a base that publishes at the pace of the test."""

    def __init__(self, sessions, missions, mapped=False, wait=False):
        self.node_session, self.session = sessions
        self.robot = FakeRobot()
        self.node = Node(self.node_session, self.robot, missions, mapped, NodeConfig(name="r", silent=0.3), wait)
        self.stop, self.commands, self.time = threading.Event(), [], 0.0
        self.camera, self.picture = CAMERA, (24, 32)  # what the base announces; rows and columns that it sends
        self.lidar = True  # whether it sends
        self._subscriber = self.session.declare_subscriber("r/cmd_vel", self._take)
        self._publishing = threading.Event()
        self._threads = [
            threading.Thread(target=self.node.run, args=(self.stop, Service())),
            threading.Thread(target=self._publish),
        ]
        self._publishing.set()
        for thread in self._threads:
            thread.start()
        self.until(self._answers)

    def _answers(self):
        try:
            return self.status() is not None
        except NoAnswer:  # its queryables are not known yet
            return False

    def _take(self, sample):
        self.commands.append(twist_from_message(decode(messages.Twist, sample.payload.to_bytes())))

    def _publish(self):
        while not self.stop.wait(0.02):
            if not self._publishing.is_set():
                continue
            self.time += 0.1
            rgb, depth = np.full((*self.picture, 3), 100, np.uint8), np.ones(self.picture, np.float32)
            scan = LaserScan(self.time, np.full(36, 2.0, np.float32), -np.pi, np.pi / 18, 8.0, None)
            for topic, message in (
                *([("scan", scan_to_message(scan, 0.1))] if self.lidar else []),
                ("camera/camera_info", camera_to_message(self.time, self.camera)),
                ("camera/depth/image_raw", depth_to_message(self.time, depth)),
                ("camera/color/image/compressed", color_to_message(self.time, rgb)),
                ("odom", odometry_to_message(self.time, (0.1 * self.time, 0.0, 0.0), (0.1, 0.0))),
            ):
                self.session.put(f"r/{topic}", encode(message))

    def ask(self, key, body, kind, timeout=10):
        return ask(self.session, f"r/{key}", body, kind, timeout)

    def status(self):
        return self.ask("status", requests.Status(), requests.StatusReply)

    def until(self, condition):
        deadline = time.monotonic() + 10
        while not condition():
            assert time.monotonic() < deadline, "it never came true"
            time.sleep(0.01)

    def silence(self):
        self._publishing.clear()

    def close(self):
        self.stop.set()
        for thread in self._threads:
            thread.join(10)


def missions(map_steps=5, find_steps=5, find=None, **kwargs):
    return Missions(
        lambda robot: Drive(robot, map_steps, mapped(), **kwargs),
        find or (lambda robot, request: Drive(robot, find_steps, found(robot), **kwargs)),
    )
