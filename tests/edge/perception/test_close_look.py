"""Windows of a picture: where they lie, and what they say about where things are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edge.camera import CameraModel
from edge.perception.close_look import look_closely, to_remember, window_at
from edge.perception.encoder import View, column_bearings

CAMERA = CameraModel()


class Spy:
    """Notes what it is shown."""

    def __init__(self):
        self.windows = []

    def encode_image(self, rgb, hfov=CAMERA.hfov, window=None):
        self.windows.append(window)
        left, _, right, _ = window or (0, 0, rgb.shape[1], rgb.shape[0])
        vectors = np.eye(4, dtype=np.float32) * len(self.windows)
        return View(vectors, np.full(4, column_bearings((left + right) / 2, rgb.shape[1], hfov)), None, window)


def test_the_whole_picture_then_three_windows_from_left_to_right():
    spy = Spy()
    views = list(look_closely(spy, np.zeros((240, 320, 3), np.uint8)))
    assert spy.windows == [None, (0, 90, 160, 240), (80, 90, 240, 240), (160, 90, 320, 240)]
    vectors, bearings = to_remember(views)
    assert vectors.shape == (4, 4) and [row.max() for row in vectors] == [1, 2, 3, 4]
    assert bearings[0] == bearings[2] == 0 and bearings[1] == pytest.approx(-bearings[3]) and bearings[1] > 0.3


def test_a_view_that_was_made_already_is_not_made_again():
    spy = Spy()
    whole = View(np.eye(4), np.zeros(4), None)
    assert next(look_closely(spy, np.zeros((240, 320, 3), np.uint8), whole)) is whole
    assert None not in spy.windows


@given(st.floats(-50, 400), st.floats(-50, 300))
def test_the_window_follows_the_object_and_stays_in_the_picture(u, v):
    left, top, right, bottom = window_at((u, v), 320, 240)
    assert (right - left, bottom - top) == (160, 150)
    assert 0 <= left and right <= 320 and 0 <= top and bottom <= 240
    if 80 <= u <= 240 and 75 <= v <= 165:
        assert abs((left + right) / 2 - u) <= 0.5 and abs((top + bottom) / 2 - v) <= 0.5


def test_column_bearings_agree_with_the_camera():
    edges = np.array([0, 40, 160, 300])
    assert np.allclose(column_bearings(edges, 320, CAMERA.hfov), CAMERA.bearing(edges - 0.5))
