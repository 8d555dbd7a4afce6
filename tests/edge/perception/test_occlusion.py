"""How much of an outline something nearer covers: in made-up depth pictures."""

import numpy as np
import pytest

from edge.perception.detection import Detection
from edge.perception.occlusion import hidden_share


def picture(depth=4.0):
    return np.full((240, 320), depth, np.float32)


def detection(box, mask=None):
    x0, y0, x1, y1 = box
    return Detection(box, 0.9, np.ones((y1 - y0, x1 - x0), bool) if mask is None else mask)


def test_what_stands_free_is_not_hidden():
    depth = picture()
    depth[100:140, 120:200] = 2.0
    assert hidden_share(detection((120, 100, 200, 140)), depth) == 0


def test_what_a_cupboard_cuts_off_on_one_side_is_hidden_there():
    depth = picture()
    depth[100:140, 120:160] = 2.0
    depth[:, :120] = 1.0
    share = hidden_share(detection((120, 100, 160, 140)), depth)
    assert share == pytest.approx(0.25, abs=0.04)  # one side of a square


def test_what_slants_hides_nothing_of_itself():
    depth = picture()
    depth[100:140, 60:260] = np.linspace(1.5, 3.5, 200)  # a couch, seen along its length
    assert hidden_share(detection((60, 100, 260, 140)), depth) == 0


def test_the_floor_before_it_hides_nothing():
    rows = np.arange(240)[:, None]
    depth = np.broadcast_to(np.minimum(0.88 * 200 / np.maximum(rows - 120, 1), 4.0), (240, 320)).astype(np.float32)
    depth = depth.copy()
    depth[150:208, 120:200] = depth[208, 0]  # stands there where the floor is as far as it is
    assert hidden_share(detection((120, 150, 200, 208)), depth) < 0.02


@pytest.mark.parametrize("box", [(0, 0, 320, 240), (0, 100, 40, 240), (280, 0, 320, 60)])
def test_the_border_of_the_picture_hides_nothing(box):
    assert hidden_share(detection(box), picture(2.0)) == 0


def test_a_sliver_in_a_mask_of_its_own_shape():
    mask = np.tri(20, 40, 20, dtype=bool)
    depth = picture(1.0)
    depth[100:120, 100:140][mask] = 3.0
    assert hidden_share(detection((100, 100, 140, 120), mask), depth) > 0.9
