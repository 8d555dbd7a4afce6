"""The simulated base over zenoh: in one process with a hand-made world, then as two real processes."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from edge.link import messages
from edge.link.alive import Watch
from edge.link.base import Base
from edge.link.conversions import odometry_from_message, twist_to_message
from edge.link.exchange import ask
from edge.link.messages import encode
from edge.link.requests import Truth, TruthReply
from edge.link.session import LinkConfig, LinkError, open_session
from edge.link.topic import Topic, publisher
from edge.observation import RgbdFrame, Twist
from edge.pose import between
from firmware_sim.node import Node, NodeConfig
from firmware_sim.world import World, WorldConfig


class Rig:
    """A node that runs a world in a thread, and a session to meet it with."""

    def __init__(self, sessions, world, **config):
        self.world, self.session, self.stop = world, sessions[1], threading.Event()
        self.node = Node(sessions[0], world, NodeConfig(name="r", **config))
        self.thread = threading.Thread(target=self.node.run, args=(self.stop,))

    def start(self):
        self.thread.start()

    def until(self, condition, timeout=20):
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, "it never came true"
            time.sleep(0.005)


@pytest.fixture
def rig(sessions, furnished):
    rigs = []

    def make(**config):
        rigs.append(Rig(sessions, World(furnished, config=WorldConfig(camera=False)), **config))
        return rigs[-1]

    yield make
    for made in rigs:
        made.stop.set()
        if made.thread.is_alive():
            made.thread.join(10)


def test_it_speaks_on_the_topics_of_a_ros_base(rig):
    rig = rig(speed=10.0)
    kinds = {
        "odom": messages.Odometry,
        "imu": messages.Imu,
        "bumper": messages.Bool,
        "scan": messages.LaserScan,
        "camera/camera_info": messages.CameraInfo,
        "battery_state": messages.BatteryState,
        "ground_truth/odom": messages.Odometry,
    }
    topics = {key: Topic(rig.session, f"r/{key}", kind) for key, kind in kinds.items()}
    rig.start()
    rig.until(lambda: all(topic.read_latest() is not None for topic in topics.values()))
    scan, imu = topics["scan"].read_latest(), topics["imu"].read_latest()
    assert len(scan.ranges) == 360 and scan.header.frame_id == "base_link" and scan.scan_time == pytest.approx(0.1)
    assert imu.linear_acceleration.z == 9.81 and imu.orientation_covariance[0] == -1
    assert topics["bumper"].read_latest().data is False
    assert topics["camera/camera_info"].read_latest().width == 320
    assert 0.9 < topics["battery_state"].read_latest().percentage <= 1
    assert topics["ground_truth/odom"].read_latest().header.frame_id == "house"
    truth = odometry_from_message(topics["ground_truth/odom"].read_latest())[1]
    np.testing.assert_allclose(truth, rig.world.house.start, atol=0.01)


def test_it_obeys_and_its_watchdog_stops_it(rig):
    rig = rig(speed=5.0, patience=0.05)
    odom = Topic(rig.session, "r/odom", messages.Odometry)
    commands = publisher(rig.session, "r/cmd_vel", command=True)
    rig.start()
    rig.until(lambda: odom.read_latest() is not None)
    deadline = time.monotonic() + 0.3
    while time.monotonic() < deadline:
        commands.put(twist_to_message(Twist(0.3, 0.0)))
        time.sleep(0.01)
    rig.until(lambda: odometry_from_message(odom.read_latest())[2][0] < 0.01)  # no command: the dead-man's switch
    driven = odometry_from_message(odom.read_latest())[1][0]
    assert driven > 0.1
    assert between(rig.world.house.start, rig.world.truth)[0] == pytest.approx(driven, abs=0.1)


@pytest.mark.parametrize("payload", [b"noise", encode(messages.Twist(messages.Vector3(x=float("nan"))))])
def test_a_bad_command_is_ignored(rig, payload, caplog):
    rig = rig(speed=10.0)
    rig.start()
    rig.until(lambda: rig.world.time > 0.1)
    rig.session.put("r/cmd_vel", payload)
    rig.until(lambda: caplog.text)
    then = rig.world.time
    rig.until(lambda: rig.world.time > then + 0.2)
    np.testing.assert_allclose(rig.world.truth, rig.world.house.start, atol=0.01)


def test_real_time_is_kept(rig):
    rig = rig(speed=2.0)
    started = time.monotonic()
    rig.start()
    rig.until(lambda: rig.world.time >= 1.0)
    assert time.monotonic() - started >= 0.45


def test_a_hurried_world_waits_for_a_robot_that_thinks(rig):
    """At 50 times real time, a robot that needs 20 ms for a command would else see the world jump by a second."""
    rig = rig(speed=50.0, patience=5.0)
    odom = Topic(rig.session, "r/odom", messages.Odometry)
    commands = publisher(rig.session, "r/cmd_vel", command=True)
    rig.start()
    rig.until(lambda: odom.read_latest() is not None)
    commands.put(twist_to_message(Twist(0.1, 0.0)))
    time.sleep(0.1)
    stamps = []
    for _ in range(10):
        time.sleep(0.02)
        stamps.append(odom.read_latest().header.stamp.seconds)
        commands.put(twist_to_message(Twist(0.1, 0.0)))
    assert np.diff(stamps).max() <= 0.1 + 1e-6 and np.diff(stamps).min() > 0
    assert rig.world.contacts == 0


def test_a_silent_robot_is_not_waited_for(rig):
    rig = rig(speed=50.0, patience=0.1)
    rig.start()
    rig.until(lambda: rig.world.time > 0)
    rig.session.put("r/cmd_vel", encode(messages.Twist()))
    then = rig.world.time
    rig.until(lambda: rig.world.time > then + 2.0, timeout=5)


def test_judges_may_ask_for_the_truth(rig, monkeypatch):
    rig = rig(speed=10.0)
    monkeypatch.setattr(rig.world, "visible_fraction", lambda object_id: 0.25)  # these boxes have no pictures
    rig.world.house.add_object("Lamp-A", "lamp", 5.0, 2.0, 0.0)
    rig.start()
    rig.until(lambda: rig.world.time > 0)
    reply = ask(rig.session, "r/ground_truth/objects", Truth("Cube"), TruthReply, 5)
    assert [(thing.id, thing.position, thing.visible) for thing in reply.objects] == [("cube-1", (6.0, 1.0, 0.0), 0.25)]
    assert reply.start == (1.0, 2.0, 0.0) and reply.contacts == 0
    (lamp,) = ask(rig.session, "r/ground_truth/objects", Truth("Lamp-A"), TruthReply, 5).objects
    assert lamp.id == "Lamp-A"
    everything = ask(rig.session, "r/ground_truth/objects", Truth(), TruthReply, 5)
    assert {thing.id for thing in everything.objects} == set(rig.world.house.objects)
    assert ask(rig.session, "r/ground_truth/objects", Truth("unicorn"), TruthReply, 5).objects == []


def test_pictures_and_depth_are_one_observation(sessions, furnished, monkeypatch):
    world = World(furnished, config=WorldConfig(camera=False))
    rgb, depth = np.full((240, 320, 3), 77, np.uint8), np.full((240, 320), 1.5, np.float32)
    monkeypatch.setattr(world, "_frame", lambda odom: RgbdFrame(world.time, rgb, depth, odom))
    rig = Rig(sessions, world, speed=2.0)
    base = Base(rig.session, "r")
    time.sleep(0.05)
    rig.start()
    seen = []
    try:
        rig.until(lambda: seen.append(base.observe()) or any(s is not None and s.frame is not None for s in seen))
        rig.until(lambda: base.camera(world.config.camera_model) is not None)
    finally:
        rig.stop.set()
        rig.thread.join(10)
    frame = next(s.frame for s in seen if s is not None and s.frame is not None)
    assert frame.rgb.shape == (240, 320, 3) and abs(int(frame.rgb[9, 9, 0]) - 77) < 3
    np.testing.assert_allclose(frame.depth, 1.5, atol=0.001)


def run_sim(*arguments):
    environment = os.environ | {"ORT_DISABLE_TELEMETRY": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "firmware_sim.node", "--no-multicast-scouting", *arguments]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment)


@pytest.mark.timeout(90)
def test_as_a_process_of_its_own(endpoint):
    """House, sensors and wire for real: observations arrive, a command moves the base, SIGTERM ends it cleanly."""
    process = run_sim("--listen", endpoint, "--speed", "4", "--seed", "3")
    try:
        link = LinkConfig(connect=(endpoint,), multicast_scouting=False)
        with open_session(link, threading.Event()) as session:
            watch = Watch(session, "robot1/alive/*")
            base = Base(session, "robot1")
            assert watch.wait(lambda alive: "robot1/alive/base" in alive, 60), process.poll()
            seen, deadline = [], time.monotonic() + 30
            while sum(s.frame is not None for s in seen) < 10 and time.monotonic() < deadline:
                observation = base.observe()
                if observation is not None:
                    seen.append(observation)
                    base.command(Twist(0.0, 0.5))
                time.sleep(0.002)
            frames = [s.frame for s in seen if s.frame is not None]
            assert len(frames) >= 10 and all(frame.rgb.std() > 5 for frame in frames)
            assert all(np.isfinite(frame.depth).all() and frame.depth.max() > 0.5 for frame in frames)
            assert abs(seen[-1].odom[2] - seen[0].odom[2]) > 0.1
            reply = ask(session, "robot1/ground_truth/objects", Truth(), TruthReply, 10)
            assert len(reply.objects) >= 25
            process.send_signal(signal.SIGTERM)
            assert watch.wait(lambda alive: not alive, 10)
        assert process.wait(10) == 0
        assert process.stderr.read() == ""
    finally:
        process.kill()
        process.communicate()


@pytest.mark.timeout(60)
@pytest.mark.parametrize("arguments, said", [(("--home", "nowhere"), "apartment"), (("--speed", "0"), "positive")])
def test_a_mistake_is_one_clear_sentence(endpoint, arguments, said):
    process = run_sim("--listen", endpoint, *arguments)
    errors = process.communicate(timeout=50)[1]
    assert process.returncode == 2 and said in errors and "Traceback" not in errors


@pytest.mark.timeout(60)
def test_a_busy_port_is_one_clear_sentence(endpoint):
    with open_session(LinkConfig(listen=(endpoint,), multicast_scouting=False)):
        with pytest.raises(LinkError):
            open_session(LinkConfig(listen=(endpoint,), multicast_scouting=False))
        process = run_sim("--listen", endpoint)
        errors = process.communicate(timeout=50)[1]
    assert process.returncode == 2 and "already in use" in errors and "Traceback" not in errors
