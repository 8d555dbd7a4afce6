"""Against rosbags, an independent CDR encoder that knows the ROS 2 definitions."""

import dataclasses
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pycdr2 import IdlStruct
from rosbags.typesys import Stores, get_typestore

from edge.link import messages
from edge.link.messages import MessageError, decode, encode, stamp_of

ROS = get_typestore(Stores.ROS2_HUMBLE)
KINDS = [kind for kind in vars(messages).values() if isinstance(kind, type) and dataclasses.is_dataclass(kind)]


def ros_name(kind):
    return kind.__idl_typename__.replace(".", "/")


def to_ros(value, description=None):
    """The same message as rosbags' type; sequences and arrays of numbers become numpy arrays, as rosbags wants them."""
    if isinstance(value, IdlStruct):
        name = ros_name(type(value))
        return ROS.types[name](**{f: to_ros(getattr(value, f), d) for f, d in ROS.fielddefs[name][1]})
    if isinstance(value, bytes):
        return np.frombuffer(value, np.uint8)
    if isinstance(value, list):
        return np.array(value, np.dtype(description[1][0][1][0]))
    return value


floats = st.floats(allow_nan=False, width=32)


def filled(kind, draw):
    """A message of ``kind`` with drawn values in every field."""
    values = {}
    for f in dataclasses.fields(kind):
        default = f.default_factory() if f.default_factory is not dataclasses.MISSING else f.default
        if isinstance(default, IdlStruct):
            values[f.name] = filled(type(default), draw)
        elif isinstance(default, bool):
            values[f.name] = draw(st.booleans())
        elif isinstance(default, float):
            values[f.name] = draw(floats)
        elif isinstance(default, int):
            values[f.name] = draw(st.integers(0, 255))
        elif isinstance(default, str):
            letters = st.characters(exclude_characters="\0", exclude_categories=["Cs"])
            values[f.name] = draw(st.text(letters, max_size=9))
        elif isinstance(default, bytes):
            values[f.name] = draw(st.binary(max_size=50))
        else:
            size = len(default) or draw(st.integers(0, 9))
            values[f.name] = draw(st.lists(floats, min_size=size, max_size=size))
    return kind(**values)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@settings(max_examples=8, deadline=None)
@given(data=st.data())
def test_byte_for_byte_what_ros_sends(kind, data):
    message = filled(kind, data.draw)
    payload = encode(message)
    assert bytes(ROS.serialize_cdr(to_ros(message), ros_name(kind))) == payload
    assert decode(kind, payload) == message


def test_every_topic_of_the_design_has_its_type():
    names = {ros_name(kind) for kind in KINDS}
    assert names >= {
        "geometry_msgs/msg/Twist",
        "nav_msgs/msg/Odometry",
        "sensor_msgs/msg/Imu",
        "sensor_msgs/msg/LaserScan",
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CameraInfo",
        "sensor_msgs/msg/BatteryState",
    }


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@settings(max_examples=10, deadline=None)
@given(payload=st.binary(max_size=200))
def test_noise_is_a_message_or_a_message_error(kind, payload):
    try:
        assert isinstance(decode(kind, payload), kind)
    except MessageError as error:
        assert kind.__idl_typename__ in str(error)


def test_a_length_that_lies_is_an_error_and_no_memory():
    payload = bytearray(encode(messages.CompressedImage(data=b"abc")))
    payload[-8:-4] = struct.pack("<I", 0xFFFF_FFFF)
    with pytest.raises(MessageError):
        decode(messages.LaserScan, bytes(payload[:20]))


@given(seconds=st.floats(0, 2**31 - 2))
def test_stamps_keep_the_nanosecond(seconds):
    stamp = messages.Time.of(seconds)
    assert 0 <= stamp.nanosec < 1_000_000_000
    assert stamp.seconds == pytest.approx(seconds, abs=1e-6)
    assert stamp_of(encode(messages.Imu(messages.Header(stamp, "base_link")))) == stamp.seconds


def test_the_stamp_of_a_stub():
    with pytest.raises(MessageError, match="too few"):
        stamp_of(b"\0\1\0\0")
