import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.depth_view import DepthView, DepthViewConfig

CAMERA, CONFIG = CameraModel(), DepthViewConfig()
STAND = np.zeros(3)
BLIND = (CAMERA.mount_height - CONFIG.min_height) * CAMERA.focal / (CAMERA.height - 1 - CAMERA.centre[1])


def read(depth):
    return DepthView.read(depth, CAMERA, CONFIG, 0.05)


def ahead(view):
    """Clear stretch [m] in the camera's frame on its axis, or None."""
    on_axis = np.flatnonzero(np.abs(view.clear_to[:, 1] / (view.clear_to[:, 0] - CAMERA.ahead)) < 0.02)
    if not len(on_axis):
        return None
    return view.clear_from[on_axis[0], 0] - CAMERA.ahead, view.clear_to[on_axis[0], 0] - CAMERA.ahead


def test_empty_floor_is_clear_from_where_low_things_would_show(depth_of):
    view = read(depth_of(STAND, [], CAMERA))
    start, end = ahead(view)
    assert start == pytest.approx(BLIND, abs=0.03) and 1.2 < start < 1.4
    assert end == pytest.approx(CONFIG.max_range, abs=0.1)
    assert len(view.obstacles) == 0


def test_obstacles_lie_on_the_surface_of_the_box_and_ground_is_clear_up_to_it(depth_of):
    view = read(depth_of(STAND, [(2.6, -0.5, 0, 3.2, 0.5, 0.6)], CAMERA))
    x, y = view.obstacles.T
    assert ((x > 2.59) & (x < 3.21) & (np.abs(y) < 0.51)).all()
    assert np.isclose(x, 2.6, atol=0.01).sum() > 100
    assert ahead(view)[1] == pytest.approx(2.5 - 0.05, abs=0.01)


@pytest.mark.parametrize(
    "low, high, seen", [(0.0, 0.08, False), (0.0, 0.15, True), (1.05, 2.0, False), (0.7, 0.75, True)]
)
def test_only_what_the_robot_would_hit_counts(depth_of, low, high, seen):
    view = read(depth_of(STAND, [(2.0, -1, low, 3.0, 1, high)], CAMERA))
    assert (len(view.obstacles) > 0) == seen


def test_behind_something_too_near_to_measure_nothing_is_clear(depth_of):
    near = (CAMERA.ahead + 0.3, -1, 0.0, CAMERA.ahead + 0.4, 1, 0.7)
    view = read(depth_of(STAND, [near, (4.2, -3, 0, 4.3, 3, 2.5)], CAMERA))
    assert ahead(view) is None


def test_missing_pixels_are_survived(depth_of):
    depth = depth_of(STAND, [(2.6, -0.5, 0, 3.2, 0.5, 0.6)], CAMERA)

    def cleared(view):
        return np.hypot(*(view.clear_to - view.clear_from).T).sum()

    whole = cleared(read(depth))
    rng = np.random.default_rng(0)
    for nothing in (0.0, np.nan, np.inf, -1.0):
        holes = np.where(rng.random(depth.shape) < 0.03, np.float32(nothing), depth)
        assert cleared(read(holes)) == pytest.approx(whole, rel=0.03)
        blank = read(np.full_like(depth, nothing))
        assert len(blank.obstacles) == 0 and len(blank.clear_to) == 0


@pytest.mark.parametrize(
    "below", [(1.9, -9, -9, 9, 9, -0.3), (4.0, -9, -9, 4.2, 9, 3)], ids=["a lower floor", "the wall beyond the stairs"]
)
def test_where_the_floor_ends_is_an_obstacle(depth_of, below):
    edge, landing = 1.9, (-1, -3, -0.2, 1.9, 3, 0)
    view = read(depth_of(STAND, [landing, below], CAMERA, floor=False))
    assert view.obstacles[:, 0].min() == pytest.approx(edge, abs=0.15)
    assert ahead(view)[1] + CAMERA.ahead < edge + 0.1
    flat = read(depth_of(STAND, [], CAMERA) * np.float32(1.05))  # a camera that errs, or a base that nods, by little
    assert len(flat.obstacles) == 0


def test_an_image_of_another_size_says_what_to_set():
    with pytest.raises(ValueError, match="camera_info"):
        read(np.zeros((100, 100), np.float32))
