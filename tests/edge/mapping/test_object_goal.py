"""The place of a detection, from its mask and the depth there."""

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.object_goal import ObjectGoal, Surface, surface
from edge.mapping.occupancy import OccupancyGrid
from edge.perception.detection import Detection
from tests.edge.mapping.test_coverage import OPEN, around

CAMERA = CameraModel()
HERE = np.array([1.0, 2.0, np.pi / 2])  # looks along +y


def box(x0=140, x1=180, y0=100, y1=140):
    return Detection((float(x0), float(y0), float(x1), float(y1)), 0.9, np.ones((y1 - y0, x1 - x0), bool))


def depth_of(metres):
    return np.full((240, 320), metres, np.float32)


def seen(depth, detection, grid=None):
    return surface(detection, depth, CAMERA, HERE, grid or OccupancyGrid())


def test_a_thing_ahead_is_where_depth_says():
    found = seen(depth_of(2.0), box())
    assert found.centroid == pytest.approx([1.0, 2.0 + CAMERA.ahead + 2.0], abs=0.02) and not found.provisional
    width = 40 * 2.0 / CAMERA.focal
    assert np.ptp(found.points[:, 0]) == pytest.approx(width, rel=0.12)


def test_a_mask_between_the_points_of_the_stride_counts_too():
    mask = np.zeros((5, 6), bool)
    mask[1:4, 1:4] = True
    found = seen(depth_of(2.0), Detection((158.0, 118.0, 164.0, 123.0), 0.9, mask))
    assert found.centroid == pytest.approx([1.0, 2.0 + CAMERA.ahead + 2.0], abs=0.05)


def test_what_shows_beside_it_does_not_count():
    depth = depth_of(4.0)
    depth[100:140, 140:170] = 2.0
    found = seen(depth, box())
    assert found.points[:, 1] == pytest.approx(2.0 + CAMERA.ahead + 2.0)
    assert found.behind is None  # a quarter of the mask: the wall around it


def test_what_may_only_stand_before_it_leaves_a_second_place():
    depth = depth_of(4.0)
    depth[100:140, 140:164] = 2.0
    found = seen(depth, box())
    assert found.centroid[1] == pytest.approx(4.0 + CAMERA.ahead, abs=0.01)
    assert found.behind.centroid[1] == pytest.approx(6.0 + CAMERA.ahead, abs=0.01) and found.behind.provisional


@pytest.mark.parametrize(("detection", "metres"), [(box(0, 40), 2.0), (box(290, 320), 2.0), (box(), 4.9)])
def test_what_is_cut_off_or_far_is_provisional(detection, metres):
    assert seen(depth_of(metres), detection).provisional


def test_without_a_return_the_map_tells():
    found = surface(box(), depth_of(0.0), CAMERA, np.zeros(3), OPEN)
    assert found.provisional and found.centroid[0] == pytest.approx(CAMERA.ahead + CAMERA.max_depth, abs=0.1)
    depth = depth_of(np.nan)
    depth[100:140, 140:150] = 1.0  # a post before it
    assert surface(box(), depth, CAMERA, np.zeros(3), OPEN).centroid[0] > 4


def test_what_is_too_far_for_depth_is_a_direction_and_no_place():
    """Seen over something low, which the map has, and the camera looks past."""
    distances = CAMERA.ahead + 0.5, 2.0, np.inf
    near, over, far = (surface(box(), depth_of(0.0), CAMERA, np.zeros(3), around(distance)) for distance in distances)
    assert near.vague and near.centroid[0] == pytest.approx(CAMERA.ahead + 0.5, abs=0.06)  # too near for the camera
    assert over.vague and over.centroid == pytest.approx(far.centroid)
    assert not seen(depth_of(2.0), box(0, 40)).vague  # cut by the edge, but there


def square(x, y, provisional=False):
    return Surface(np.array([[x - 0.2, y], [x, y], [x + 0.2, y]]), provisional)


def test_the_goal_is_the_nearest_point_and_stays_while_that_moves_little():
    goal = ObjectGoal(square(3.0, 1.0))
    assert goal.nearest([0.0, 1.0]) == pytest.approx([2.8, 1.0])
    goal.update(square(3.2, 1.0))
    assert goal.nearest([0.0, 1.0]) == pytest.approx([2.8, 1.0])
    goal.update(square(3.5, 1.0))
    assert goal.nearest([0.0, 1.0]) == pytest.approx([3.3, 1.0])


def test_a_firm_view_replaces_a_provisional_one_and_not_the_other_way_round():
    goal = ObjectGoal(square(3.0, 1.0, provisional=True))
    goal.nearest([0.0, 1.0])
    goal.update(square(3.1, 1.0))
    assert goal.nearest([0.0, 1.0]) == pytest.approx([2.9, 1.0])
    goal.update(square(3.5, 1.0))
    assert not goal.provisional and goal.centroid == pytest.approx([3.5, 1.0])
    goal.update(square(3.0, 1.0, provisional=True))
    assert not goal.provisional and goal.centroid == pytest.approx([3.5, 1.0])
    assert goal.is_at([4.0, 1.0]) and not goal.is_at([5.0, 1.0])
