from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edge.camera import CameraModel
from edge.link import conversions as convert
from edge.link import messages
from edge.link.messages import MessageError, decode, encode
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan, Twist

CAMERA = CameraModel()


def wire(message):
    """The message after a trip through CDR."""
    return decode(type(message), encode(message))


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(-3.14, 3.14), st.floats(-1, 1), st.floats(-2, 2))
def test_odometry_there_and_back(x, y, theta, v, omega):
    covariance = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])
    message = wire(convert.odometry_to_message(12.5, (x, y, theta), (v, omega), covariance=covariance))
    stamp, pose, twist = convert.odometry_from_message(message)
    assert stamp == 12.5
    np.testing.assert_allclose(pose, [x, y, theta], atol=1e-12)
    np.testing.assert_allclose(twist, [v, omega], atol=1e-12)
    full = np.reshape(message.pose.covariance, (6, 6))
    np.testing.assert_array_equal(full[np.ix_([0, 1, 5], [0, 1, 5])], covariance)
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")


def test_twist_there_and_back():
    assert convert.twist_from_message(wire(convert.twist_to_message(Twist(0.3, -0.7)))) == Twist(0.3, -0.7)


def test_a_scan_keeps_its_ranges_and_marks_what_is_no_return():
    ranges = np.array([1.0, np.inf, np.nan, 9.0, 0.01, 7.5], np.float32)
    scan = LaserScan(3.25, ranges, -np.pi, 0.1, 8.0, np.zeros(3))
    message = wire(convert.scan_to_message(scan, 0.1))
    message.range_min = 0.05
    odom = np.array([1.0, 2.0, 3.0])
    back = convert.scan_from_message(message, odom)
    np.testing.assert_array_equal(back.ranges[:6], np.array([1.0, np.inf, np.nan, np.inf, np.nan, 7.5], np.float32))
    assert len(back.ranges) == 63 and np.isnan(back.ranges[6:]).all()  # of the rest of the turn it says nothing
    assert back.stamp == 3.25 and back.range_max == 8.0 and back.odom is odom
    assert back.angle_min == pytest.approx(-np.pi) and back.angle_increment == pytest.approx(0.1)
    assert message.angle_max == pytest.approx(-np.pi + 0.5)


def test_what_a_lidar_does_not_look_at_is_not_mapped_as_free():
    scan = LaserScan(0.0, np.full(271, 3.0), np.radians(-135), np.radians(1), 8.0, np.zeros(3))
    message = convert.scan_to_message(scan, 0.1)
    grid = OccupancyGrid()
    grid.integrate_scan(np.zeros(3), convert.scan_from_message(wire(message), np.zeros(3)))
    free, unknown = (cells[grid.frame.to_cell([[2.0, 0.0], [-2.0, 0.0]])] for cells in (grid.free, grid.unknown))
    assert free.tolist() == [True, False] and unknown.tolist() == [False, True]


@pytest.mark.parametrize(
    "change",
    [
        {"ranges": []},
        {"angle_increment": 0.0},
        {"angle_increment": -1e-9},
        {"angle_increment": np.nan},
        {"angle_min": np.nan},
        {"range_max": np.inf},
    ],
)
def test_a_scan_that_is_none_is_told(change):
    scan = convert.scan_to_message(LaserScan(0.0, np.ones(4), 0.0, 0.1, 8.0, np.zeros(3)), 0.1)
    with pytest.raises(MessageError, match="a scan has no ranges|a scan.s angle_increment"):
        convert.scan_from_message(replace(scan, **change), np.zeros(3))


def test_depth_is_exact_to_half_a_millimetre_and_has_no_nan():
    depth = np.random.default_rng(0).uniform(0.5, 5.0, (24, 32)).astype(np.float32)
    depth[0, :4] = [0.0, np.nan, np.inf, 70.0]
    back = convert.depth_from_message(wire(convert.depth_to_message(1.0, depth)))
    assert back.dtype == np.float32 and back.shape == (24, 32)
    np.testing.assert_array_equal(back[0, :4], 0)
    np.testing.assert_allclose(back[1:], depth[1:], atol=0.00051)


def test_depth_of_other_drivers_float_metres_big_endian_and_padded_rows():
    depth = np.array([[1.5, 0.0, 2.5]])
    rows = np.zeros((1, 16), np.uint8)
    rows[0, :12] = np.frombuffer(depth.astype(">f4").tobytes(), np.uint8)
    message = messages.Image(height=1, width=3, encoding="32FC1", is_bigendian=1, step=16, data=rows.tobytes())
    np.testing.assert_array_equal(convert.depth_from_message(message), depth)


@pytest.mark.parametrize(
    "change, said",
    [({"encoding": "rgb8"}, "16UC1"), ({"data": b"1234567"}, "bytes of data"), ({"step": 1}, "bytes of data")],
)
def test_depth_that_is_not_depth(change, said):
    message = messages.Image(height=2, width=2, encoding="16UC1", step=4, data=b"12345678")
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(MessageError, match=said):
        convert.depth_from_message(message)


def test_colour_survives_jpeg_in_the_right_order():
    rgb = np.zeros((48, 64, 3), np.uint8)
    rgb[:, :32, 0], rgb[:, 32:, 2] = 200, 100
    back = convert.color_from_message(wire(convert.color_to_message(2.0, rgb)))
    assert np.abs(back.astype(int) - rgb)[:, 4:28].max() <= 12
    np.testing.assert_allclose(back[24, 8], [200, 0, 0], atol=8)
    np.testing.assert_allclose(back[24, 56], [0, 0, 100], atol=8)


def test_a_png_of_another_driver_is_a_picture_too():
    rgb = np.random.default_rng(1).integers(0, 255, (5, 7, 3), dtype=np.uint8)
    data = cv2.imencode(".png", rgb[:, :, ::-1])[1].tobytes()
    np.testing.assert_array_equal(convert.color_from_message(messages.CompressedImage(format="png", data=data)), rgb)


def claims(rows, cols):
    """A JPEG whose header says that it is so large."""
    data = bytearray(convert.color_to_message(1.0, np.zeros((8, 8, 3), np.uint8)).data)
    size = data.index(b"\xff\xc0") + 5
    data[size : size + 4] = rows.to_bytes(2, "big") + cols.to_bytes(2, "big")
    return bytes(data)


@pytest.mark.parametrize("data", [b"", b"no picture", claims(65_000, 65_000)])
def test_bytes_that_are_no_picture(data):
    with pytest.raises(MessageError, match="not a picture"):
        convert.color_from_message(messages.CompressedImage(format="jpeg", data=data))


def test_camera_info_there_and_back():
    back = convert.camera_from_message(wire(convert.camera_to_message(0.0, CAMERA)), CAMERA)
    assert (back.width, back.height, back.mount_height) == (320, 240, CAMERA.mount_height)
    assert back.hfov == pytest.approx(CAMERA.hfov) and back.focal == pytest.approx(CAMERA.focal)


def test_an_uncalibrated_camera_is_named():
    with pytest.raises(MessageError, match="not calibrated"):
        convert.camera_from_message(messages.CameraInfo(), CAMERA)


@pytest.mark.parametrize("reach", [60.0, 3e38])
def test_a_lidar_that_sees_farther_than_a_home_is_large_does_not_make_its_map_huge(reach):
    ranges = np.where(np.arange(360) % 90 < 4, np.inf, 2.0)
    scan = LaserScan(0.0, ranges, 0.0, np.radians(1), reach, np.zeros(3))
    grid = OccupancyGrid()
    grid.integrate_scan(np.zeros(3), convert.scan_from_message(wire(convert.scan_to_message(scan, 0.1)), np.zeros(3)))
    assert max(grid.frame.shape) * grid.resolution < 2 * convert.FARTHEST + 10
