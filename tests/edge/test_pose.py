"""Planar pose algebra against 3x3 homogeneous matrices."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from edge.pose import between, compose, rotation, transform, wrap

coordinate = st.floats(-50, 50)
poses = st.tuples(coordinate, coordinate, st.floats(-10, 10)).map(np.array)


def matrix(pose):
    x, y, theta = pose
    return np.array([[np.cos(theta), -np.sin(theta), x], [np.sin(theta), np.cos(theta), y], [0, 0, 1]])


@given(poses, poses)
def test_compose_is_the_matrix_product(a, b):
    assert np.allclose(matrix(compose(a, b)), matrix(a) @ matrix(b))


@given(poses, poses)
def test_between_undoes_compose(a, b):
    assert np.allclose(matrix(compose(a, between(a, b))), matrix(b))


@given(poses, coordinate, coordinate)
def test_transform_moves_points(pose, x, y):
    assert np.allclose(transform(pose, np.array([[x, y]]))[0], (matrix(pose) @ [x, y, 1])[:2])


@given(st.floats(-100, 100))
def test_wrap_keeps_the_direction(angle):
    assert -np.pi <= wrap(angle) < np.pi
    assert np.isclose(np.cos(wrap(angle)), np.cos(angle)) and np.isclose(np.sin(wrap(angle)), np.sin(angle))


def test_a_rotation_turns_as_composing_with_a_turn_does():
    angles = np.array([0.0, 0.4, -2.5])
    for angle, turn in zip(angles, rotation(angles), strict=True):
        np.testing.assert_allclose(turn @ [1.0, 2.0, 0.3], compose([0.0, 0.0, angle], [1.0, 2.0, 0.3]) - [0, 0, angle])
    assert rotation(0.4).shape == (3, 3)
