"""The polygon that a depth image looks over, against boxes whose every distance is known."""

import cv2
import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.mapping.view_fan import farthest, fill, view_fan
from edge.pose import transform
from tests.edge.mapping.conftest import draw, look

CAMERA = CameraModel(width=160, height=120)
NOWHERE = draw("..\n..")  # a map that hides nothing
POSE = np.array([1.0, -0.5, 0.6])


def test_it_ends_at_the_wall_or_at_the_reach():
    wall = transform(POSE, np.array([[2.1, 0.0]]))[0]  # 2 m before the lens
    depth = np.full((120, 160), 2.0, np.float32)
    corners = view_fan(POSE, depth, CAMERA, NOWHERE, 41, 2.2)
    assert corners[0] == pytest.approx(transform(POSE, np.array([[CAMERA.ahead, 0.0]]))[0])
    slant = np.linalg.norm(corners[1:] - corners[0], axis=1)
    assert corners[21] == pytest.approx(wall) and slant.max() == pytest.approx(2.2)
    bearings = np.arctan2(*(corners[1:] - corners[0]).T[::-1]) - POSE[2]
    assert bearings[0] == pytest.approx(CAMERA.bearing(0)) and bearings[-1] == pytest.approx(CAMERA.bearing(159))


def test_a_low_thing_does_not_hide_the_wall_behind_it():
    low, wall = (1.5, -0.4, 0.0, 1.8, 0.4, 0.5), (3.0, -5.0, 0.0, 3.2, 5.0, 2.5)
    depth = look(np.zeros(3), [low, wall], CAMERA, floor=False)
    assert farthest(depth, 40)[20] == pytest.approx(3.0 - CAMERA.ahead, abs=0.02)
    assert depth[90, 80] == pytest.approx(1.5 - CAMERA.ahead, abs=0.02)


@pytest.mark.parametrize("blank", [0.0, np.nan])
def test_where_nothing_came_back_the_map_tells(blank):
    room = draw("\n".join(["#" * 40, *["#" + "." * 38 + "#"] * 28, "#" * 40]))  # 4 x 3 m
    corners = view_fan((1.0, 1.5, 0.0), np.full((120, 160), blank, np.float32), CAMERA, room, 41, 5.0)
    assert corners[21] == pytest.approx([3.9, 1.5], abs=0.1)


def test_cells_in_the_polygon_are_filled():
    frame, corners = (
        GridFrame((-1.0, -2.0), 0.05, (80, 100)),
        np.array([[0.0, 0.0], [2.5, -1.2], [3.1, 0.4], [1.0, 1.3]]),
    )
    mask = np.zeros(frame.shape, np.uint8)
    fill(mask, frame, corners)
    centres, outline = frame.to_world(*np.indices(frame.shape)).reshape(-1, 2), corners.astype(np.float32)
    inside = np.array([cv2.pointPolygonTest(outline, centre, True) for centre in centres]).reshape(frame.shape)  # m
    cell = np.hypot(0.05, 0.05)  # across
    assert mask[inside > cell / 2].all() and not mask[inside < -cell].any() and (inside > cell / 2).sum() > 1000
