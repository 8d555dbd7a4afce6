"""The base's messages are put in by hand; what comes out are observations."""

import time

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.link import messages
from edge.link.base import Base
from edge.link.conversions import (
    camera_to_message,
    color_to_message,
    depth_to_message,
    header,
    odometry_to_message,
    scan_to_message,
    twist_from_message,
)
from edge.link.messages import decode, encode
from edge.observation import LaserScan, Twist

RGB = np.full((24, 32, 3), 90, np.uint8)
DEPTH = np.full((24, 32), 2.0, np.float32)


class FakeBase:
    """What a base would send. Each ``send`` returns once it has arrived at ``base``."""

    def __init__(self, session, base):
        self.session, self.base = session, base

    def send(self, topic, message, slot):
        before = slot._arrival
        deadline = time.monotonic() + 5
        self.session.put(f"r/{topic}", encode(message) if not isinstance(message, bytes) else message)
        while slot._arrival == before:
            assert time.monotonic() < deadline, f"{topic} did not arrive"
            time.sleep(0.001)

    def odom(self, stamp, x=0.0, theta=0.0):
        self.send("odom", odometry_to_message(stamp, (x, 0.0, theta), (0.1, 0.2)), self.base._odometry)

    def scan(self, stamp):
        scan = LaserScan(stamp, np.ones(4, np.float32), 0.0, 1.5, 8.0, None)
        self.send("scan", scan_to_message(scan, 0.1), self.base._scan)

    def color(self, stamp, rgb=RGB):
        self.send("camera/color/image/compressed", color_to_message(stamp, rgb), self.base._color)

    def depth(self, stamp, depth=DEPTH):
        self.send("camera/depth/image_raw", depth_to_message(stamp, depth), self.base._depth)


@pytest.fixture
def base(sessions):
    return Base(sessions[0], "r")


@pytest.fixture
def fake(sessions, base):
    time.sleep(0.05)  # until the subscriptions are known
    return FakeBase(sessions[1], base)


def test_silence_is_no_observation(base):
    assert base.observe() is None and base.age == float("inf")
    assert base.camera(CameraModel()) is None and base.problem == ""


def test_everything_of_one_tick_is_one_observation(base, fake):
    fake.color(1.0)
    fake.depth(1.0)
    fake.scan(1.0)
    fake.odom(1.0, 0.5)
    seen = base.observe()
    assert seen.stamp == seen.scan.stamp == seen.frame.stamp == 1.0
    np.testing.assert_allclose(seen.odom, [0.5, 0, 0])
    np.testing.assert_allclose(seen.scan.odom, seen.odom)
    np.testing.assert_allclose(seen.twist, [0.1, 0.2])
    assert np.abs(seen.frame.rgb.astype(int) - 90).max() < 3
    np.testing.assert_allclose(seen.frame.depth, 2.0)
    assert base.observe() is None


def test_nothing_is_handed_out_twice(base, fake):
    for topic in (fake.color, fake.depth, fake.scan, fake.odom):
        topic(1.0)
    base.observe()
    fake.odom(1.2)
    again = base.observe()
    assert again.stamp == 1.2 and again.scan is None and again.frame is None


def test_odometry_is_interpolated_at_the_sensors_stamps_the_short_way_round(base, fake):
    fake.odom(1.0, 0.0, 3.1)
    base.observe()
    fake.color(1.05)
    fake.depth(1.06)  # within half a frame period: the same picture
    fake.scan(1.075)
    fake.odom(1.1, 0.2, -3.1)
    seen = base.observe()
    gap = 2 * np.pi - 6.2
    np.testing.assert_allclose(seen.frame.odom, [0.1, 0, (3.1 + gap / 2 + np.pi) % (2 * np.pi) - np.pi], atol=1e-6)
    np.testing.assert_allclose(seen.scan.odom[:2], [0.15, 0])
    np.testing.assert_allclose(seen.odom[:2], [0.2, 0])


def test_a_sensor_ahead_of_odometry_waits_for_it(base, fake):
    fake.odom(1.0)
    base.observe()
    fake.scan(1.1)
    fake.color(1.1)
    fake.depth(1.1)
    fake.odom(1.09)
    assert base.observe() is None  # a scan will be due at any moment
    fake.odom(1.11)
    assert base.observe().scan.stamp == pytest.approx(1.1)


def test_a_slow_lidar_does_not_slow_control_down(base, fake):
    fake.odom(1.0)
    base.observe()
    fake.odom(1.12)
    assert base.observe() is None
    fake.odom(1.16)
    assert base.observe().scan is None


def test_colour_without_its_depth_is_no_picture(base, fake):
    fake.odom(0.9)
    fake.color(1.0)
    fake.depth(1.1)
    fake.odom(1.2)
    assert base.observe().frame is None
    fake.color(1.1)  # late, but now there is a pair
    fake.odom(1.4)
    assert base.observe().frame.stamp == pytest.approx(1.1)


def test_a_base_that_starts_anew_is_noticed(base, fake):
    fake.odom(100.0)
    base.observe()
    fake.odom(0.5)
    assert base.observe().stamp == 0.5 and base.restarts == 1
    fake.odom(0.3)  # late or reordered by a little: ignored
    assert base.observe() is None and base.restarts == 1


def test_so_is_one_whose_clock_goes_on(base, fake):
    fake.odom(100.0, 5.0)
    base.observe()
    fake.odom(103.0, 8.0)  # it was not heard for three seconds, and drove on
    assert base.observe().odom[0] == 8.0 and base.restarts == 0
    fake.odom(106.0, 0.0)
    assert base.observe().odom[0] == 0.0 and base.restarts == 1


@pytest.mark.parametrize("breaks", ["odom", "scan", "colour", "size", "nan"])
def test_bad_messages_are_told_and_survived(base, fake, breaks):
    if breaks == "odom":
        fake.send("odom", b"noise", base._odometry)
    if breaks == "nan":
        fake.odom(0.9, np.nan)
    if breaks == "scan":
        fake.send("scan", b"noise", base._scan)
    if breaks == "colour":
        image = messages.CompressedImage(header(1.0, "c"), "jpeg", b"noise")
        fake.send("camera/color/image/compressed", image, base._color)
        fake.depth(1.0)
    if breaks == "size":
        fake.color(1.0)
        fake.depth(1.0, np.ones((12, 16), np.float32))
    if breaks in ("odom", "nan"):
        assert base.observe() is None and base.problem
    fake.odom(1.0)
    seen = base.observe()
    assert seen.stamp == 1.0 and seen.frame is None and seen.scan is None
    assert bool(base.problem) == (breaks not in ("odom", "nan"))  # the newest odometry was good
    for send in (fake.scan, fake.color, fake.depth, fake.odom):
        send(1.5)
    base.observe()
    assert base.problem == ""


def test_a_sensor_that_falls_silent_is_named(base, fake):
    def goes_on(start, *sensors):
        for stamp in start + 0.3 * np.arange(1, 6):
            for send in (*sensors, fake.odom):
                send(stamp)
            base.observe()

    fake.odom(100.0)
    base.observe()
    assert base.silent == ""  # it has only just begun
    goes_on(100.0, fake.scan, fake.color, fake.depth)
    assert base.silent == ""
    goes_on(101.5, fake.color, fake.depth)
    assert "lidar" in base.silent
    goes_on(103.0, fake.scan)
    assert "camera" in base.silent
    goes_on(104.5, lambda stamp: fake.scan(stamp + 5), fake.color, fake.depth)  # its clock is ahead
    assert "lidar" in base.silent and "clock" in base.silent
    goes_on(106.0, fake.scan, lambda stamp: fake.color(stamp + 50), lambda stamp: fake.depth(stamp + 50))
    assert "camera" in base.silent and "clock" in base.silent


def test_the_camera_is_the_announced_one(base, fake):
    announced = CameraModel(width=64, height=48, hfov=1.0)
    fake.send("camera/camera_info", camera_to_message(0.0, announced), base._info)
    camera = base.camera(CameraModel(mount_height=0.4))
    assert (camera.width, camera.height, camera.mount_height) == (64, 48, 0.4)
    assert camera.hfov == pytest.approx(1.0)


def test_a_touch_between_two_observations_is_not_missed(base, fake):
    bumper = base._bumper
    for pressed in (False, True, False):
        fake.send("bumper", messages.Bool(pressed), bumper)
    fake.odom(0.1)
    assert base.observe().bumper
    fake.odom(0.4)
    assert not base.observe().bumper
    fake.send("bumper", messages.Bool(True), bumper)
    for stamp in (0.7, 1.0):  # for as long as it is pressed
        fake.odom(stamp)
        assert base.observe().bumper


def test_commands_arrive(base, sessions):
    taken = []
    subscriber = sessions[1].declare_subscriber("r/cmd_vel", lambda sample: taken.append(sample.payload.to_bytes()))
    time.sleep(0.05)
    base.command(Twist(0.3, -0.5))
    deadline = time.monotonic() + 5
    while not taken and time.monotonic() < deadline:
        time.sleep(0.005)
    assert twist_from_message(decode(messages.Twist, taken[0])) == Twist(0.3, -0.5)
    subscriber.undeclare()


def test_colour_waits_for_a_depth_that_is_late(base, fake):
    """By 0.12 s, at 30 pictures a second."""
    frames, late = [], 4
    for step in range(40):
        stamp = step / 30
        fake.color(stamp)
        if step >= late:
            fake.depth(stamp - late / 30)
        fake.odom(stamp)
        observation = base.observe()
        frames += [observation.frame.stamp] if observation is not None and observation.frame is not None else []
    assert len(frames) > 5 and np.all(np.diff(frames) > 0)
    assert len(base._colors) <= late + 2  # those before the last pair do not stay


def test_halves_of_pictures_that_never_belong_together_are_told(base, fake):
    for stamp in 0.1 * np.arange(1, 16):
        fake.color(stamp)
        fake.depth(stamp - 0.05)
        fake.scan(stamp)
        fake.odom(stamp)
        base.observe()
    assert "do not belong together" in base.silent
