"""The wiring, with a robot and missions that are as simple as can be."""

import sqlite3
import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.link import messages, requests
from edge.link.alive import declare_alive
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
from edge.link.requests import RequestError
from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg
from edge.node import Missions, Node, NodeConfig, main
from edge.observation import STOP, LaserScan, Twist
from edge.planning.local_search import Replan
from edge.service import Service

CAMERA = CameraModel(width=32, height=24)


class FakeRobot:
    """Believes odometry, and has room for what the node reports."""

    def __init__(self):
        self.encoder = SimpleNamespace(name="tower", digest="abc", dim=4)
        self.memory = Vlpg.open(":memory:", "tower", "abc", 4)
        self.camera, self.grid = CameraModel(), OccupancyGrid()
        self.coverage = SimpleNamespace(viewed=np.zeros((0, 0), np.uint8))
        self.stamp, self.pose, self.distance = 0.0, np.zeros(3), 0.0
        self.localizer = SimpleNamespace(lost=False)
        self.observations = []

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


@pytest.fixture
def rig(sessions):
    rigs = []

    def start(missions, mapped=False, wait=False):
        rigs.append(Rig(sessions, missions, mapped, wait))
        return rigs[-1]

    yield start
    for started in rigs:
        started.close()


def missions(map_steps=5, find_steps=5, find=None, **kwargs):
    return Missions(
        lambda robot: Drive(robot, map_steps, mapped(), **kwargs),
        find or (lambda robot, request: Drive(robot, find_steps, found(robot), **kwargs)),
    )


def test_it_maps_then_finds_and_tells(rig):
    rig = rig(missions())
    rig.until(lambda: rig.status().state == "idle")
    status = rig.status()
    assert status.mapped and status.outcome == "mapped" and status.problem == ""
    assert status.area > 1.0 and status.memory > 10 and status.step_time > 0
    assert Twist(0.2, 0.1) in rig.commands
    assert rig.robot.memory.load_map() is not None
    reply = rig.ask("find", requests.Find("cup"), requests.FindReply)
    assert (reply.status, reply.object, reply.position, reply.confidence) == ("found", "cup", (1.0, 2.0), 0.7)
    assert reply.score == 0.9
    assert reply.box == (1.0, 2.0, 3.0, 4.0) and reply.jpeg[:2] == b"\xff\xd8"
    assert reply.hypotheses[0].members == [(1.1, 0.0, 0.6), (1.0, 0.0, 0.5)]
    (replan,) = reply.replans
    assert replan.probability.numpy().tolist() == [[0, 255], [26, 51]]
    assert (replan.origin, replan.resolution, replan.pose) == ((-1.0, 0.5), 0.05, (1.0, 0.0, 0.0))
    assert rig.status().outcome == "found"


def test_the_mission_gets_whole_observations_at_the_control_rate(rig):
    rig = rig(missions(map_steps=20))
    rig.until(lambda: rig.status().state == "idle")
    seen = rig.robot.observations
    steps = np.diff([observation.stamp for observation in seen])
    assert (steps > 0.075).all() and np.median(steps) < 0.25
    assert sum(observation.scan is not None for observation in seen) > len(seen) * 0.6
    assert sum(observation.frame is not None for observation in seen) > len(seen) * 0.6
    assert (rig.robot.camera.width, rig.robot.camera.height) == (32, 24)  # the announced camera


def test_map_and_graph(rig):
    rig = rig(missions(), mapped=True)
    rig.until(lambda: rig.status().stamp > 0.5)
    rig.robot.memory.add(0.0, (1, 2, 3), np.eye(3), np.eye(4)[:2], [0.0, 0.1])
    reply = rig.ask("map", requests.Map(), requests.MapReply)
    assert set(np.unique(reply.cells.numpy())) == {-1, 0, 100}
    assert reply.path.numpy().shape[1] == 2 and reply.resolution == 0.05
    graph = rig.ask("graph", requests.Graph(vectors_from=0), requests.GraphReply)
    np.testing.assert_allclose(graph.poses.numpy(), [[1, 2, 3]])
    assert graph.vectors.data.numpy().shape == (2, 4) and graph.vectors.owners.numpy().tolist() == [0, 0]
    assert rig.ask("graph", requests.Graph(), requests.GraphReply).vectors is None
    assert len(rig.ask("graph", requests.Graph(vectors_from=1), requests.GraphReply).vectors.owners.numpy()) == 0


def test_one_thing_at_a_time_and_cancel(rig):
    rig = rig(missions(find_steps=10**6), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    answer = []
    asking = threading.Thread(target=lambda: answer.append(rig.ask("find", requests.Find("cup"), requests.FindReply)))
    asking.start()
    rig.until(lambda: rig.status().state == "finding")
    with pytest.raises(RequestError, match="looking for cup.*cancel"):
        rig.ask("find", requests.Find("sofa"), requests.FindReply)
    assert rig.ask("cancel", requests.Cancel(), requests.CancelReply).cancelled
    asking.join(10)
    assert answer[0].status == "cancelled" and answer[0].duration >= 0
    assert not rig.ask("cancel", requests.Cancel(), requests.CancelReply).cancelled
    rig.until(lambda: rig.commands[-1:] == [STOP])


def test_a_known_home_is_toured_again_on_request(rig, sessions, monkeypatch):
    straightened = []
    monkeypatch.setattr("edge.node.straighten", lambda *given: straightened.append(given) or carry_ahead(*given))
    host = declare_alive(sessions[1], "host/alive/test")
    rig = rig(missions(), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    reply = rig.ask("tour", requests.Tour(), requests.TourReply)
    assert (reply.status, reply.duration, reply.distance, reply.nodes) == ("complete", 9.0, 4.0, 0)
    rig.until(lambda: rig.status().state == "idle")
    assert rig.status().outcome == "mapped" and len(straightened) == 1
    host.undeclare()


def test_in_an_unknown_home_it_waits_if_told_to_and_explores_when_asked(rig):
    asked = []

    def find(robot, request):
        asked.append(request)
        return Drive(robot, 3, found(robot))

    rig = rig(missions(find=find), wait=True)
    rig.until(lambda: rig.status().stamp > 0)
    assert rig.status().state == "idle" and not rig.status().mapped
    assert rig.ask("find", requests.Find("cup", explore=True), requests.FindReply).status == "found"
    assert asked == [requests.Find("cup", explore=True)] and not rig.status().mapped


def test_a_tour_that_is_cut_short_or_cancelled_leaves_the_home_known(rig):
    ends = [mapped(complete=False)]
    tours = Missions(lambda robot: Drive(robot, 5 if ends else 10**6, ends.pop() if ends else None), None)
    rig = rig(tours, mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    assert rig.ask("tour", requests.Tour(), requests.TourReply).status == "timeout"
    rig.until(lambda: rig.status().state == "idle")
    assert rig.status().mapped
    answer = []
    asking = threading.Thread(target=lambda: answer.append(rig.ask("tour", requests.Tour(), requests.TourReply)))
    asking.start()
    rig.until(lambda: rig.status().state == "mapping")
    with pytest.raises(RequestError, match="mapping its home.*cancel"):
        rig.ask("tour", requests.Tour(), requests.TourReply)
    assert rig.ask("cancel", requests.Cancel(), requests.CancelReply).cancelled
    asking.join(10)
    assert answer[0].status == "cancelled" and answer[0].nodes == 0 and rig.status().mapped


def test_an_object_that_cannot_be_looked_for_is_refused(rig):
    def find(robot, request):
        raise ValueError("no such word")

    rig = rig(missions(find=find), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    with pytest.raises(RequestError, match="no such word") as caught:
        rig.ask("find", requests.Find("xyzzy"), requests.FindReply)
    assert caught.value.field == "object"
    assert rig.status().state == "idle"


def test_a_silent_base_is_told_to_stop_and_so_are_people(rig):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: Twist(0.2, 0.1) in rig.commands)
    rig.silence()
    rig.until(lambda: rig.commands[-1:] == [STOP])
    rig.until(lambda: "no odometry" in rig.status().problem)
    assert rig.status().state == "mapping"
    rig._publishing.set()
    rig.until(lambda: rig.commands[-1] == Twist(0.2, 0.1))


def test_while_a_sensor_is_silent_the_mission_waits(rig):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: Twist(0.2, 0.1) in rig.commands)
    rig.lidar = False
    rig.until(lambda: "lidar sends nothing" in rig.status().problem)
    rig.until(lambda: rig.commands[-1:] == [STOP])
    assert rig.status().state == "mapping"
    rig.lidar = True
    rig.until(lambda: rig.commands[-1] == Twist(0.2, 0.1))
    assert rig.status().problem == ""


def test_after_the_base_started_anew_the_growing_map_is_saved_as_before(rig, monkeypatch):
    rig = rig(missions(map_steps=10**6))
    rig.node.config = replace(rig.node.config, save_every=1.0)
    rig.time = 10_000.0
    rig.until(lambda: rig.status().stamp > 10_001)
    rig.time = 0.0
    rig.until(lambda: rig.status().state == "idle" and rig.status().stamp < 100)
    asking = threading.Thread(
        target=lambda: pytest.raises(RequestError, rig.ask, "tour", requests.Tour(), requests.TourReply)
    )
    asking.start()
    rig.until(lambda: rig.status().state == "mapping")
    saved = []
    monkeypatch.setattr(rig.robot.memory, "save_map", saved.append)
    rig.until(lambda: len(saved) > 2)
    rig.stop.set()
    asking.join(10)


def test_a_mission_that_breaks_stops_the_robot_and_keeps_the_map_and_the_next_may_do_better(rig, caplog):
    def find(robot, request):
        return Drive(robot, 3, found(robot), breaks=request.object == "zero")

    rig = rig(missions(breaks=True, find=find))
    rig.until(lambda: rig.status().state == "idle")
    rig.until(lambda: rig.commands and rig.commands[-1] == STOP)
    assert "divided by zero" in rig.status().problem and not rig.status().mapped
    assert rig.robot.memory.load_map() is not None
    with pytest.raises(RequestError, match="divided by zero"):
        rig.ask("find", requests.Find("zero"), requests.FindReply)
    assert rig.ask("find", requests.Find("cup"), requests.FindReply).status == "found"
    assert rig.status().problem == ""


def test_a_base_that_starts_anew_ends_the_mission_and_the_robot_seeks_its_place(rig):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: rig.time > 3 and rig.status().stamp > 2)
    rig.time = 0.0
    rig.until(lambda: rig.status().state == "idle")
    assert "restarted" in rig.status().problem and rig.robot.localizer.lost
    rig.until(lambda: rig.status().stamp < 2)


@pytest.mark.parametrize(("complete", "outcome"), [(True, "mapped"), (False, "mapped in part: timeout")])
def test_only_a_home_that_was_mapped_to_the_end_is_mapped_when_the_robot_wakes_up_again(rig, complete, outcome):
    rig = rig(Missions(lambda robot: Drive(robot, 3, mapped(complete)), None))
    rig.until(lambda: rig.status().state == "idle")
    assert rig.status().outcome == outcome and rig.robot.memory.mapped == complete


def test_pictures_of_an_unknown_camera_are_not_looked_at(rig):
    rig = rig(missions(), mapped=True)
    rig.until(lambda: any(seen.frame is not None for seen in rig.robot.observations))
    rig.picture = (30, 40)
    rig.until(lambda: "camera_info for pictures of 40 x 30" in rig.status().problem)
    count = len(rig.robot.observations)
    rig.until(lambda: len(rig.robot.observations) > count + 10)
    assert all(seen.frame is None for seen in rig.robot.observations[count + 2 :])
    rig.camera = CameraModel(width=40, height=30)
    rig.until(lambda: rig.robot.observations[-1].frame is not None)
    assert rig.robot.camera.width == 40 and rig.status().problem == ""


def test_a_full_disk_is_told_and_survived(rig, monkeypatch, caplog):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: rig.status().state == "mapping")

    def full(data):
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr(rig.robot.memory, "save_map", full)
    rig.ask("cancel", requests.Cancel(), requests.CancelReply)
    assert "disk is full" in rig.status().problem and rig.status().state == "idle"


def test_a_full_disk_at_the_first_picture_does_not_end_the_process(rig, monkeypatch, caplog):
    def full(hfov):
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr(Vlpg, "note_camera", lambda memory, hfov: full(hfov))
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: "disk is full" in rig.status().problem)
    assert rig.status().state == "idle"


def test_stopping_the_process_stops_the_robot_and_refuses_who_waits(rig):
    rig = rig(missions(find_steps=10**6), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    errors = []

    def ask_for_it():
        try:
            rig.ask("find", requests.Find("cup"), requests.FindReply)
        except (RequestError, NoAnswer) as error:
            errors.append(str(error))

    asking = threading.Thread(target=ask_for_it)
    asking.start()
    rig.until(lambda: rig.status().state == "finding")
    rig.close()
    asking.join(10)
    assert "shutting down" in errors[0]
    rig.until(lambda: rig.commands[-1:] == [STOP])


def carry_ahead(session, robot):
    """What a host makes of the graph: everything is 5 m further."""
    return np.zeros((1, 3)), np.array([[5.0, 0.0, 0.0]])


def refuse(session, robot):
    raise RequestError("the graph is in several pieces")


def break_down(session, robot):
    raise ZeroDivisionError("a fault of ours")


@pytest.mark.parametrize(("answer", "ahead"), [(carry_ahead, 5.0), (refuse, 0.0), (break_down, 0.0)])
def test_with_a_host_a_mapped_graph_is_straightened_and_the_path_goes_along(rig, sessions, monkeypatch, answer, ahead):
    asked = []
    monkeypatch.setattr("edge.node.straighten", lambda *given: asked.append(given[1]) or answer(*given))
    host = declare_alive(sessions[1], "host/alive/test")
    robot = rig(missions(map_steps=30))
    robot.until(lambda: robot.status().state == "idle")
    assert asked == [robot.robot] and robot.status().outcome == "mapped" and not robot.status().problem
    path = robot.ask("map", requests.Map(), requests.MapReply).path.numpy()
    assert ahead <= path[0, 0] < ahead + 3
    host.undeclare()


def test_without_a_host_the_graph_stays_as_it_is(rig, monkeypatch):
    asked = []
    monkeypatch.setattr("edge.node.straighten", lambda *given: asked.append(given) or carry_ahead(*given))
    robot = rig(missions())
    robot.until(lambda: robot.status().state == "idle")
    assert robot.status().outcome == "mapped" and not asked


def test_a_wrong_option_is_told(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--threads", "0"])
    assert ended.value.code == 2 and "--threads must be at least 1" in capsys.readouterr().err
