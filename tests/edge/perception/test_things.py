"""Boxes in an empty room, drawn into a depth picture by hand."""

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.perception.things import alone, find_things

CAMERA = CameraModel()
WALL = 3.5  # m


def room(*boxes):
    """Depth (240, 320) of floor and wall, and of ``boxes``: depth, left and right edge, height over the floor [m]."""
    v, u = np.mgrid[:240, :320]
    fall = (v - CAMERA.centre[1]) / CAMERA.focal
    with np.errstate(divide="ignore"):
        depth = np.where(fall > 0, np.minimum(CAMERA.mount_height / np.maximum(fall, 1e-9), WALL), WALL)
    for z, left, right, height in sorted(boxes, reverse=True):
        x0, _, _ = CAMERA.project([[z + CAMERA.ahead, left, height]])
        x1, y0, _ = CAMERA.project([[z + CAMERA.ahead, right, height]])
        inside = (u >= x0) & (u <= x1) & (v >= y0) & (depth > z)
        depth[inside] = z
    return depth.astype(np.float32)


def test_an_empty_room_has_no_things():
    assert find_things(room(), CAMERA) == []
    assert find_things(np.zeros((240, 320), np.float32), CAMERA) == []
    assert find_things(np.full((240, 320), np.nan, np.float32), CAMERA) == []


def test_a_box_is_found_where_it_stands():
    (thing,) = find_things(room((2.0, 0.4, -0.1, 0.7)), CAMERA)
    assert thing.depth == pytest.approx(2.0)
    assert thing.point[:2] == pytest.approx([2.0 + CAMERA.ahead, 0.15], abs=0.03)
    corners = CAMERA.project([[2.0 + CAMERA.ahead, 0.4, 0.7], [2.0 + CAMERA.ahead, -0.1, 0.0]])
    assert thing.box == pytest.approx((corners[0][0], corners[1][0], corners[0][1], corners[1][1]), abs=6)


def test_things_at_different_depths_are_two_though_one_hides_the_other():
    things = find_things(room((1.5, 0.3, 0.0, 0.5), (2.2, 0.3, -0.5, 0.9)), CAMERA)
    assert sorted(thing.depth for thing in things) == pytest.approx([1.5, 2.2])
    assert not (things[0].mask & things[1].mask)[10:-10].sum() > 400  # but for the seam


def test_the_larger_in_the_picture_comes_first_and_a_speck_not_at_all():
    things = find_things(room((2.0, 1.0, 0.7, 0.4), (2.0, 0.2, -0.6, 0.8), (2.0, 0.5, 0.48, 0.1)), CAMERA)
    assert len(things) == 2 and things[0].point[1] < things[1].point[1]


def test_what_reaches_the_ceiling_is_no_thing():
    assert find_things(room((2.6, 0.6, 0.0, 2.4)), CAMERA) == []


def test_noise_and_lost_pixels_make_no_things():
    rng = np.random.default_rng(0)
    depth = room()
    depth += 0.0012 * depth**2 * rng.standard_normal(depth.shape).astype(np.float32)
    depth[rng.random(depth.shape) < 0.004] = 0
    assert find_things(depth, CAMERA) == []


def test_a_thing_alone_keeps_its_pixels_and_loses_its_surroundings():
    (thing,) = find_things(room((2.0, 0.4, -0.1, 0.7)), CAMERA)
    rgb = np.random.default_rng(0).integers(0, 255, (240, 320, 3), np.uint8)
    before = rgb.copy()
    picture, (left, top, right, bottom) = alone(rgb, thing)
    assert np.array_equal(rgb, before)
    assert np.array_equal(picture[thing.mask], rgb[thing.mask])
    around = picture[top:bottom, left:right][~thing.mask[top:bottom, left:right]]
    assert len(around) and (around == around[0]).all()
    x0, y0, x1, y1 = thing.box
    assert 0 <= left <= x0 and x1 <= right <= 320 and 0 <= top <= y0 and y1 <= bottom <= 240
    assert (right - left) / (bottom - top) == pytest.approx(4 / 3, abs=0.02)


def test_a_thing_that_fills_the_picture_is_shown_whole():
    (thing,) = find_things(room((0.8, 0.6, -0.6, 1.2)), CAMERA)
    assert alone(np.zeros((240, 320, 3), np.uint8), thing)[1] == (0, 0, 320, 240)
