import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from edge.pose import transform
from firmware_sim.polygons import contains, distance_to_segments, edges, penetration

SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
number = st.floats(-3, 3)


@given(number, number, number)
def test_penetration_of_squares_agrees_with_the_intersection_of_opencv(x, y, yaw):
    other = transform((x, y, yaw), SQUARE)
    area, _ = cv2.intersectConvexConvex(SQUARE.astype(np.float32), other.astype(np.float32))
    depth = penetration(SQUARE, other)
    if depth > 1e-3:
        assert area > 0
    elif depth < -1e-3:
        assert area == 0
    np.testing.assert_allclose(depth, penetration(other, SQUARE), atol=1e-9)


@given(number, number)
def test_contains_agrees_with_opencv(x, y):
    bent = np.array([[0, 0], [2, 0], [2, 2], [1, 2], [1, 1], [0, 1]], np.float32)
    inside = cv2.pointPolygonTest(bent, (x, y), True)
    if abs(inside) > 1e-3:
        assert contains(bent, np.array([x, y])) == (inside > 0)


@given(number, number)
def test_distance_to_the_sides_agrees_with_opencv(x, y):
    expected = abs(cv2.pointPolygonTest(SQUARE.astype(np.float32), (x, y), True))
    np.testing.assert_allclose(distance_to_segments(np.array([x, y]), edges(SQUARE)), expected, atol=1e-5)


def test_distance_to_nothing_is_infinite():
    assert distance_to_segments(np.zeros(2), np.zeros((0, 2, 2))) == np.inf
