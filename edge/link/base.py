"""The robot's base as the node sees it over zenoh: observations in, velocity commands out."""

import logging
from collections import deque
from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel
from edge.link import messages
from edge.link.conversions import (
    camera_from_message,
    color_from_message,
    depth_from_message,
    odometry_from_message,
    scan_from_message,
    twist_to_message,
)
from edge.link.messages import MessageError, decode, stamp_of
from edge.link.topic import Topic, publisher
from edge.observation import Observation, RgbdFrame
from edge.pose import wrap

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class BaseConfig:
    """When an observation is due, and what belongs together."""

    period: float = 0.1  # s of the base's clock between observations: the control step of the missions
    wait_for_scan: float = 0.05  # s that a due observation waits for a scan; a slower lidar does not slow control down
    same_picture: float = 0.02  # s between the stamps of colour and depth of one picture; half a frame at 25 Hz
    remembered: int = 100  # odometry messages kept to interpolate in: 2 s at 50 Hz
    halves: int = 10  # pictures of colour, or of depth, that wait for the other: 0.3 s at 30 Hz
    quiet: float = 1.0  # s of the base's clock without a scan or a picture, after which a robot should not drive on
    restarted: float = 1.0  # s; a clock that jumps back by more belongs to a base that was restarted
    leap: float = 0.3  # m that odometry errs by from one message to the next, and
    fastest: float = 2.0  # m/s that a base drives; if odometry moves further, it has begun anew


class Base:
    """Assembles observations from the newest messages, in the thread of whoever calls it."""

    def __init__(self, session, name, wake=None, config=None):
        """``name``: key root, e.g. ``robot1``. ``wake``: called when an observation may have become due."""
        self.config = config or BaseConfig()
        self._problems: dict[str, str] = {}  # by topic, what is wrong with its newest message
        self.restarts = 0  # how often the base's clock, and with it its odometry, began anew
        self._odometry = Topic(session, f"{name}/odom", messages.Odometry, keep=50, wake=wake)
        self._scan = Topic(session, f"{name}/scan", messages.LaserScan, wake=wake)
        self._color = Topic(session, f"{name}/camera/color/image/compressed", messages.CompressedImage, keep=3)
        self._depth = Topic(session, f"{name}/camera/depth/image_raw", messages.Image, keep=3)
        self._bumper = Topic(session, f"{name}/bumper", messages.Bool, keep=50)
        self._info = Topic(session, f"{name}/camera/camera_info", messages.CameraInfo)
        self._commands = publisher(session, f"{name}/cmd_vel", command=True)
        self._forget()

    def _forget(self):
        self._stamps = deque(maxlen=self.config.remembered)
        self._poses = deque(maxlen=self.config.remembered)
        self._twist = np.zeros(2)
        self._last = self._last_scan = self._last_frame = -np.inf  # stamps of what was last handed out
        self._first = np.inf  # of the first odometry
        self._colors, self._depths = (deque(maxlen=self.config.halves) for _ in range(2))  # (stamp, payload)
        self._pressed = False  # what the bumper said last

    @property
    def problem(self):
        """What is wrong with the base's newest messages, for people; empty if nothing."""
        return next(iter(self._problems.values()), "")

    @property
    def silent(self):
        """Which sensor has been silent for too long to drive on, for people; empty if none."""
        for sensor, last in (("lidar", self._last_scan), ("camera", self._last_frame)):
            if self._last - max(last, self._first) > self.config.quiet:
                if sensor == "camera" and self._comes(self._colors) and self._comes(self._depths):
                    return "the camera's colour and depth pictures do not belong together: no two have nearly one stamp"
                return f"the {sensor} sends nothing, or with stamps that are not of the odometry's clock"
        return ""

    def _comes(self, halves):
        return bool(halves) and abs(halves[-1][0] - self._last) < self.config.quiet

    @property
    def age(self):
        """Seconds of wall time since odometry last arrived; inf before it ever did."""
        return self._odometry.age

    def command(self, twist):
        """Sends a velocity command. The base's own dead-man's switch stops it when none follows within 250 ms."""
        self._commands.put(twist_to_message(twist))

    def camera(self, mounted: CameraModel):
        """The camera that the base announces, or None while it has not; ``mounted`` says where it sits."""
        try:
            info = self._info.read_latest()
            camera = info and camera_from_message(info, mounted)
        except MessageError as error:
            self._complain("camera_info", error)
            return None
        self._problems.pop("camera_info", None)
        return camera

    def observe(self):
        """The next ``Observation`` when one is due, else None. Call it whenever ``wake`` was called."""
        self._take_odometry()
        if not self._stamps or self._stamps[-1] < self._last + self.config.period * 0.75:
            return None
        now = self._stamps[-1]
        scan = self._new_scan(now)
        if scan is None and now < self._last + self.config.period + self.config.wait_for_scan:
            return None
        self._last = now
        return Observation(now, self._poses[-1], self._twist, scan, self._new_frame(now), self._was_touched())

    def _take_odometry(self):
        for payload in self._odometry.take():
            try:
                stamp, pose, twist = odometry_from_message(decode(messages.Odometry, payload))
            except MessageError as error:
                self._complain("odom", error)
                continue
            if not (np.isfinite(pose).all() and np.isfinite(twist).all()):
                self._complain("odom", "odometry with NaN or infinity")
                continue
            self._problems.pop("odom", None)
            if self._stamps and self._began_anew(stamp, pose):
                self.restarts += 1
                self._forget()
            self._first = min(self._first, stamp)
            if not self._stamps or stamp > self._stamps[-1]:
                self._stamps.append(stamp)
                self._poses.append(pose)
                self._twist = twist

    def _began_anew(self, stamp, pose):
        """Whether odometry with this ``stamp`` and ``pose (3,)`` cannot go on from the last one.

        A base that measures time since it was switched on begins at zero again; one with a clock begins at the origin.
        """
        passed = stamp - self._stamps[-1]
        far = self.config.leap + self.config.fastest * max(passed, 0.0)
        return passed < -self.config.restarted or np.hypot(*(pose - self._poses[-1])[:2]) > far

    def _was_touched(self):
        """Whether the bumper was pressed at any time since the last observation; a short touch counts too."""
        touched = self._pressed
        for payload in self._bumper.take():
            try:
                self._pressed = decode(messages.Bool, payload).data
                self._problems.pop("bumper", None)
            except MessageError as error:
                self._complain("bumper", error)
            touched |= self._pressed
        return touched

    def _new_scan(self, now):
        try:
            message = self._scan.read_latest()
            stamp = message.header.stamp.seconds if message is not None else -np.inf
            odom = self._odom_at(stamp) if self._last_scan < stamp <= now + 1e-6 else None
            if odom is None:
                return None
            scan = scan_from_message(message, odom)
        except MessageError as error:
            self._complain("scan", error)
            return None
        self._problems.pop("scan", None)
        self._last_scan = stamp
        return scan

    def _new_frame(self, now):
        """The newest picture whose colour and depth belong together and whose odometry is known."""
        try:
            for waiting, topic in ((self._colors, self._color), (self._depths, self._depth)):
                waiting.extend((stamp_of(payload), payload) for payload in topic.take())
            for stamp, color in reversed(self._colors):
                if not self._last_frame < stamp <= now + 1e-6 or (odom := self._odom_at(stamp)) is None:
                    continue
                pairs = [d for d in self._depths if abs(d[0] - stamp) <= self.config.same_picture]
                if pairs:
                    self._last_frame = stamp
                    depth = min(pairs, key=lambda pair: abs(pair[0] - stamp))[1]
                    for waiting in (self._colors, self._depths):
                        while waiting and waiting[0][0] <= stamp:
                            waiting.popleft()
                    frame = self._decode_frame(stamp, color, depth, odom)
                    self._problems.pop("camera", None)
                    return frame
        except MessageError as error:
            self._complain("camera", error)
        return None

    def _decode_frame(self, stamp, color, depth, odom):
        rgb = color_from_message(decode(messages.CompressedImage, color))
        depth = depth_from_message(decode(messages.Image, depth))
        if rgb.shape[:2] != depth.shape:
            raise MessageError(
                f"the colour picture is {rgb.shape[1]} x {rgb.shape[0]} and the depth {depth.shape[1]} x "
                f"{depth.shape[0]}; set the camera driver to align depth to colour"
            )
        return RgbdFrame(stamp, rgb, depth, odom)

    def _odom_at(self, stamp):
        """Pose ``(3,)`` in the odom frame at ``stamp``, interpolated; None before the oldest message kept."""
        stamps = self._stamps
        if not stamps or stamp < stamps[0] - 1e-6:
            return None
        after = len(stamps) - 1
        while after > 0 and stamps[after - 1] >= stamp:
            after -= 1
        if after == 0 or stamp >= stamps[after]:
            return self._poses[after]
        share = (stamp - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
        a, b = self._poses[after - 1], self._poses[after]
        step = b - a
        step[2] = wrap(step[2])
        pose = a + share * step
        pose[2] = wrap(pose[2])
        return pose

    def _complain(self, topic, problem):
        if str(problem) != self._problems.get(topic):
            log.warning("%s", problem)
        self._problems[topic] = str(problem)
