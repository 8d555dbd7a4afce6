"""A lidar scan as a node keeps it: every second beam in millimetres, and where the lidar was beside the node."""

import struct

import numpy as np

from edge.observation import LaserScan

EVERY = 2  # beams; 180 of 360 still give a pose to a centimetre, in 400 bytes
_HEADER = struct.Struct("<6f")
_SILENT, _ENDLESS = 0, 65535  # no measurement; nothing within range


def pack(scan: LaserScan, offset) -> bytes:
    """``offset (3,)``: the scan's pose seen from the node's."""
    ranges = np.asarray(scan.ranges[::EVERY], np.float64)
    millimetres = np.clip(np.nan_to_num(ranges * 1000, nan=_SILENT, posinf=_ENDLESS), 0, _ENDLESS)
    header = _HEADER.pack(scan.angle_min, scan.angle_increment * EVERY, scan.range_max, *offset)
    return header + millimetres.round().astype("<u2").tobytes()


def unpack(data: bytes) -> tuple[LaserScan, np.ndarray]:
    """The scan, without stamp and odometry, and its pose (3,) seen from the node's.

    Raises:
        ValueError: the bytes are damaged.
    """
    if len(data) < _HEADER.size or (len(data) - _HEADER.size) % 2:
        raise ValueError(f"a scan of {len(data)} bytes is damaged")
    angle_min, increment, range_max, *offset = _HEADER.unpack_from(data)
    millimetres = np.frombuffer(data, "<u2", offset=_HEADER.size)
    ranges = (millimetres / 1000).astype(np.float32)
    ranges[millimetres == _SILENT], ranges[millimetres == _ENDLESS] = np.nan, np.inf
    return LaserScan(0.0, ranges, angle_min, increment, range_max, np.zeros(3)), np.array(offset)
