"""Cells and places."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from edge.mapping.grid import GridFrame

FRAME = GridFrame((-1.0, 2.0), 0.05, (40, 60))
COORDINATE = st.floats(-5, 5)


@given(COORDINATE, COORDINATE)
def test_a_place_lies_within_half_a_cell_of_its_cell(x, y):
    row, col = FRAME.to_cell(np.array([x, y]))
    assert np.abs(FRAME.to_world(row, col) - (x, y)).max() <= 0.025 + 1e-9


@given(COORDINATE, COORDINATE, st.floats(0, 3))
def test_within_is_the_disc_around_a_place(x, y, radius):
    rows, cols = np.indices(FRAME.shape)
    away = np.hypot(*np.moveaxis(FRAME.to_world(rows, cols) - (x, y), -1, 0))
    mask = FRAME.within(radius, (x, y))
    assert mask.shape == FRAME.shape
    assert (mask == (away <= radius))[np.abs(away - radius) > 1e-9].all()


def test_a_larger_frame_holds_what_a_smaller_one_had():
    larger = GridFrame((-1.5, 1.0), 0.05, (80, 90))
    array = np.arange(40 * 60).reshape(40, 60)
    held = larger.holding(array, FRAME, -1)
    place = FRAME.to_world(3, 7)
    assert held[larger.to_cell(place)] == array[3, 7] and (held >= 0).sum() == array.size
