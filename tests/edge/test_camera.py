"""Projection and unprojection are inverse, and the field of view is the stated one."""

from math import radians

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from edge.camera import CameraModel

camera = CameraModel()


@given(st.floats(-0.5, 319.5), st.floats(-0.5, 239.5), st.floats(0.5, 5))
def test_project_undoes_unproject(u, v, depth):
    back = camera.project(camera.unproject(u, v, depth)[None])
    assert np.allclose([axis[0] for axis in back], [u, v, depth])


def test_outer_edges_of_the_outer_columns_span_the_field_of_view():
    assert np.isclose(camera.bearing(-0.5) - camera.bearing(319.5), radians(79))


def test_a_point_to_the_left_and_below_lands_left_and_low():
    (u,), (v,), (z,) = camera.project([[2.1, 0.5, 0.0]])
    assert u < camera.centre[0] and v > camera.centre[1] and np.isclose(z, 2.0)
