import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from edge.mapping import map_bytes

PACKED = map_bytes.pack(0.05, np.array([-3, 7]), np.arange(-90, 90, dtype=np.int8).reshape(3, 6, 10))


@settings(deadline=None)
@given(arrays(np.int8, st.tuples(st.just(3), st.integers(1, 20), st.integers(1, 20))), st.integers(-999, 999))
def test_round_trip(layers, row):
    resolution, corner, got = map_bytes.unpack(map_bytes.pack(0.05, np.array([row, 5]), layers))
    assert resolution == 0.05 and corner.tolist() == [row, 5]
    np.testing.assert_array_equal(got, layers)
    got += 0  # writable


@settings(deadline=None)
@given(st.integers(0, len(PACKED) - 1), st.integers(1, 255))
def test_any_changed_byte_is_noticed(position, change):
    damaged = bytearray(PACKED)
    damaged[position] ^= change
    with pytest.raises(ValueError, match="map"):
        map_bytes.unpack(bytes(damaged))


@settings(deadline=None)
@given(st.integers(0, len(PACKED) - 1))
def test_any_cut_is_noticed(length):
    with pytest.raises(ValueError, match="map the home again"):
        map_bytes.unpack(PACKED[:length])


@pytest.mark.parametrize("data", [b"", b"not a map at all, but long enough to hold a header" * 2, PACKED + b"x"])
def test_what_is_no_map_is_refused(data):
    with pytest.raises(ValueError, match="map the home again"):
        map_bytes.unpack(data)


def test_another_version_says_so():
    other = bytearray(PACKED)
    struct.pack_into("<B", other, len(map_bytes.MAGIC), 9)
    with pytest.raises(ValueError, match="format 9"):
        map_bytes.unpack(bytes(other))
