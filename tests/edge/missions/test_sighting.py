"""From a box and a depth image to a place in the map."""

from types import SimpleNamespace

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.occupancy import OccupancyGrid
from edge.missions.sighting import sight
from edge.observation import LaserScan, RgbdFrame
from edge.perception.detection import Detection

CAMERA = CameraModel()


class BoxDetector:
    """Finds a box in every view that has one."""

    def detect(self, view, target, image_size):
        return view


def robot(depth, pose=(0.0, 0.0, 0.0)):
    frame = RgbdFrame(1.0, np.zeros((240, 320, 3), np.uint8), depth, np.array(pose))
    return SimpleNamespace(frame=frame, camera=CAMERA, in_map=lambda odom: odom, grid=OccupancyGrid())


def box(u, v=120, half=10, score=0.8):
    """With its middle at pixel (u, v)."""
    edges = u - half + 0.5, v - half + 0.5, u + half + 0.5, v + half + 0.5
    return Detection(edges, score, np.ones((2 * half, 2 * half), bool))


def test_the_object_is_placed_where_box_and_depth_say():
    depth = np.full((240, 320), 2.0, np.float32)
    seen = sight(robot(depth, (1.0, 1.0, np.pi / 2)), BoxDetector(), None, [box(CAMERA.centre[0])])
    assert seen.position == pytest.approx([1.0, 1.0 + CAMERA.ahead + 2.0])
    assert seen.bearing == pytest.approx(0) and seen.depth == 2.0


def test_an_object_in_the_left_of_the_picture_lies_to_the_left():
    seen = sight(robot(np.full((240, 320), 2.0, np.float32)), BoxDetector(), None, [box(60)])
    assert seen.bearing > 0 and seen.position[1] > 0


def test_what_shows_behind_the_object_does_not_move_it_away():
    depth = np.full((240, 320), 4.0, np.float32)
    depth[100:140, 155:165] = 1.5  # half of the box's middle
    seen = sight(robot(depth), BoxDetector(), None, [box(160, half=20)])
    assert seen.depth == 1.5


def test_what_is_much_farther_in_the_box_may_be_the_object_behind_another():
    depth = np.full((240, 320), 4.0, np.float32)
    depth[100:140, 155:165] = 1.5
    seen = sight(robot(depth), BoxDetector(), None, [box(CAMERA.centre[0], half=20)])
    assert seen.behind == pytest.approx([CAMERA.ahead + 4.0, 0.0])
    depth[depth == 4.0] = 1.8  # one thing's own depth
    assert sight(robot(depth), BoxDetector(), None, [box(160, half=20)]).behind is None


@pytest.mark.parametrize("nothing", [0.0, np.nan])
def test_without_a_return_the_object_is_beyond_the_sensor(nothing):
    seen = sight(robot(np.full((240, 320), nothing, np.float32)), BoxDetector(), None, [box(160)])
    assert seen.depth == CAMERA.max_depth


def test_too_near_for_the_sensor_the_map_tells_the_depth():
    """Half a metre before a cupboard that fills the picture, a depth camera returns nothing."""
    near = robot(np.zeros((240, 320), np.float32))
    around = LaserScan(0.0, np.full(360, 0.5, np.float32), -np.pi, 2 * np.pi / 360, 8.0, np.zeros(3))
    near.grid.integrate_scan(np.zeros(3), around)
    seen = sight(near, BoxDetector(), None, [box(160, half=80)])
    assert seen.depth == pytest.approx(0.5 - CAMERA.ahead, abs=0.05)


def test_the_view_that_shows_it_best_counts():
    depth = np.full((240, 320), 2.0, np.float32)
    seen = sight(robot(depth), BoxDetector(), None, [None, box(60, score=0.6), box(260, score=0.9)])
    assert seen.detection.score == 0.9
    assert sight(robot(depth), BoxDetector(), None, [None, None]) is None
