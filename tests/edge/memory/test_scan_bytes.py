import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from edge.memory.scan_bytes import EVERY, pack, unpack
from edge.observation import LaserScan

RANGES = hnp.arrays(np.float32, st.integers(0, 400), elements=st.floats(0.0625, 60, width=32) | st.just(np.inf))


@given(RANGES, st.tuples(*[st.floats(-1, 1, width=32)] * 3))
def test_a_scan_comes_back_to_the_millimetre(ranges, offset):
    scan = LaserScan(3.0, ranges, -3.0, 0.01, 8.0, np.zeros(3))
    back, where = unpack(pack(scan, offset))
    np.testing.assert_allclose(back.ranges, ranges[::EVERY], atol=6e-4)
    assert (back.angle_min, back.range_max) == pytest.approx((-3.0, 8.0))
    assert back.angle_increment == pytest.approx(0.01 * EVERY)
    np.testing.assert_allclose(where, offset)


def test_what_was_not_measured_stays_unknown():
    back, _ = unpack(pack(LaserScan(0, np.array([np.nan, 1.0, np.inf, 1.0]), 0, 0.1, 8, np.zeros(3)), (0, 0, 0)))
    assert np.isnan(back.ranges[0]) and np.isinf(back.ranges[1])


@pytest.mark.parametrize("data", [b"", b"x" * 23, b"x" * 25])
def test_damaged_bytes_are_refused(data):
    with pytest.raises(ValueError, match="damaged"):
        unpack(data)
