"""Between the core's types (edge.observation, numpy) and ROS 2 messages."""

from math import atan2, cos, sin

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.jpeg import jpeg
from edge.link import messages
from edge.link.messages import MessageError
from edge.observation import LaserScan, Twist

FARTHEST = 12.0  # m; rooms of a home are smaller, and the map grows by what a beam without an echo clears
FINEST = np.radians(0.01)  # rad between beams; finer steps are a mistake, and would make scans of any size
JPEG_QUALITY = 85  # no visible artefacts at 320 x 240, about 20 kB


def header(stamp, frame):
    """The header of a message about ``frame`` at ``stamp`` [s]."""
    return messages.Header(messages.Time.of(stamp), frame)


def twist_to_message(twist):
    """The Twist [m/s, rad/s] of a planar base."""
    return messages.Twist(messages.Vector3(x=twist.v), messages.Vector3(z=twist.omega))


def twist_from_message(message):
    """Twist of a planar base: forward speed and turn rate; the other axes do not exist."""
    return Twist(message.linear.x, message.angular.z)


def odometry_to_message(stamp, pose, twist, frame="odom", covariance=None):
    """``pose (3,)`` of base_link in ``frame`` and ``twist (2,)`` in base_link; ``covariance (3, 3)`` of the pose."""
    x, y, theta = (float(value) for value in pose)
    message = messages.Odometry(header(stamp, frame), "base_link")
    message.pose.pose = messages.Pose(messages.Point(x, y), messages.Quaternion(z=sin(theta / 2), w=cos(theta / 2)))
    message.twist.twist = messages.Twist(messages.Vector3(x=float(twist[0])), messages.Vector3(z=float(twist[1])))
    if covariance is not None:
        full = np.zeros((6, 6))
        full[np.ix_([0, 1, 5], [0, 1, 5])] = covariance
        message.pose.covariance = full.ravel().tolist()
    return message


def odometry_from_message(message):
    """Stamp [s], planar pose ``(3,)`` and twist ``(2,)`` [m/s, rad/s]."""
    position, q = message.pose.pose.position, message.pose.pose.orientation
    theta = atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
    twist = message.twist.twist
    pose = np.array([position.x, position.y, theta])
    return message.header.stamp.seconds, pose, np.array([twist.linear.x, twist.angular.z])


def scan_to_message(scan, scan_time):
    """``scan_time`` [s] between scans."""
    ranges = np.asarray(scan.ranges, np.float32)
    return messages.LaserScan(
        header(scan.stamp, "base_link"),
        angle_min=scan.angle_min,
        angle_max=scan.angle_min + (len(ranges) - 1) * scan.angle_increment,
        angle_increment=scan.angle_increment,
        scan_time=scan_time,
        range_max=scan.range_max,
        ranges=ranges.tolist(),
    )


def scan_from_message(message, odom):
    """``odom (3,)``: base pose in the odom frame at the stamp.

    As in REP 117, ranges beyond the sensor's reach are inf, no return; what is too near for it, or is no number, is NaN
    and says nothing. A lidar that reaches farther than ``FARTHEST`` is taken for one that does not. Where a lidar does
    not look all around, beams of NaN fill up the turn.

    Raises MessageError for a scan without ranges, with beams too close for a lidar, or with angles that are no numbers.
    """
    ranges, step = np.array(message.ranges, np.float32), message.angle_increment
    if not len(ranges) or not np.isfinite([message.angle_min, step, message.range_max]).all():
        raise MessageError("a scan has no ranges, or an angle or range_max that is no number")
    if abs(step) < FINEST:
        raise MessageError(f"a scan's angle_increment of {step:g} rad cannot be that of a lidar")
    reach = min(message.range_max, FARTHEST)
    with np.errstate(invalid="ignore"):
        ranges[ranges > reach] = np.inf
        ranges[ranges < message.range_min] = np.nan
    unseen = max(round(2 * np.pi / abs(step)) - len(ranges), 0)
    ranges = np.concatenate([ranges, np.full(unseen, np.nan, np.float32)])
    return LaserScan(message.header.stamp.seconds, ranges, message.angle_min, message.angle_increment, reach, odom)


def color_to_message(stamp, rgb):
    """RGB ``(H, W, 3)`` uint8 as JPEG."""
    data = jpeg(rgb, JPEG_QUALITY)
    return messages.CompressedImage(header(stamp, "camera_optical"), "rgb8; jpeg compressed bgr8", data)


def color_from_message(message):
    """RGB ``(H, W, 3)`` uint8. Raises MessageError when the bytes are no picture."""
    data = np.frombuffer(message.data, np.uint8)
    try:
        rgb = cv2.imdecode(data, cv2.IMREAD_COLOR_RGB) if len(data) else None
    except cv2.error:  # as for a size of millions of pixels a side
        rgb = None
    if rgb is None:
        raise MessageError(f"{len(data)} bytes of {message.format!r} are not a picture")
    return rgb


def depth_to_message(stamp, depth):
    """Depth ``(H, W)`` float32 [m] as 16UC1 millimetres; no return, and what does not fit, is 0."""
    millimetres = np.nan_to_num(depth * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
    millimetres[(millimetres < 0) | (millimetres > 65_535)] = 0
    data = np.rint(millimetres).astype("<u2")
    rows, cols = data.shape
    return messages.Image(header(stamp, "camera_optical"), rows, cols, "16UC1", 0, 2 * cols, data.tobytes())


def depth_from_message(message):
    """Depth ``(H, W)`` float32 [m], 0 = no return. Raises MessageError unless it is 16UC1 or 32FC1."""
    kinds = {"16UC1": ("u2", np.float32(0.001)), "32FC1": ("f4", np.float32(1.0))}
    if message.encoding not in kinds:
        raise MessageError(f"depth comes as {message.encoding!r}; set the driver to 16UC1 (mm) or 32FC1 (m)")
    code, scale = kinds[message.encoding]
    dtype = np.dtype((">" if message.is_bigendian else "<") + code)
    if message.step < message.width * dtype.itemsize or len(message.data) != message.step * message.height:
        raise MessageError(f"a {message.width} x {message.height} depth image with {len(message.data)} bytes of data")
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    depth = np.ascontiguousarray(rows[:, : message.width * dtype.itemsize]).view(dtype)
    return np.nan_to_num(depth.astype(np.float32), copy=False, nan=0.0, posinf=0.0, neginf=0.0) * scale


def camera_to_message(stamp, camera):
    """The CameraInfo of a pinhole camera without distortion."""
    f, (u0, v0) = camera.focal, camera.centre
    return messages.CameraInfo(
        header(stamp, "camera_optical"),
        camera.height,
        camera.width,
        "plumb_bob",
        [0.0] * 5,
        [f, 0.0, u0, 0.0, f, v0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        [f, 0.0, u0, 0.0, 0.0, f, v0, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def camera_from_message(message, mounted):
    """The camera of a CameraInfo; where it sits and its depth range come from ``mounted`` (CameraModel).

    Its optical axis is taken to go through the middle of the picture, which is taken to be rectified.

    Raises MessageError for a picture without a size or a focal length.
    """
    f = message.k[0]
    if not (message.width and message.height and 0 < f < np.inf):
        raise MessageError("the camera_info is not calibrated: it has no size or no focal length")
    hfov = 2 * atan2(message.width / 2, f)
    return CameraModel(
        message.width, message.height, hfov, mounted.mount_height, mounted.ahead, mounted.left,
        mounted.min_depth, mounted.max_depth,
    )  # fmt: skip
