"""The image Jacobian against finite differences of the camera, and predictions against exact geometry."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.camera import CameraModel
from edge.planning.centring import (
    CentringConfig,
    ImageTarget,
    centred,
    centring_cost,
    image_jacobian,
    predict,
    seen_after,
)
from edge.pose import between

CAMERA = CameraModel(ahead=0.12, left=0.05)


def seen_from(pose, thing):
    x, y, _ = between(pose, [*thing, 0.0])
    u, _, depth = CAMERA.project([[x, y, 0.5]])
    return float(u[0]) - CAMERA.centre[0], float(depth[0])


@given(st.floats(1.0, 5.0), st.floats(-0.6, 0.6), st.sampled_from([(1.0, 0.0), (0.0, 1.0)]))
def test_jacobian_equals_finite_differences_of_the_camera(distance, bearing, motion):
    thing = CAMERA.ahead + distance * np.cos(bearing), distance * np.sin(bearing)
    v, omega = motion
    h = 1e-5
    e, depth = seen_from(np.zeros(3), thing)
    (e_a, z_a), (e_b, z_b) = (seen_from(np.array([t * v, 0.0, t * omega]), thing) for t in (-h, h))
    de_dv, de_dw, dz_dv, dz_dw = image_jacobian(np.float64(e), depth, CAMERA)
    assert de_dv * v + de_dw * omega == pytest.approx((e_b - e_a) / (2 * h), rel=1e-5, abs=1e-3)
    assert dz_dv * v + dz_dw * omega == pytest.approx((z_b - z_a) / (2 * h), rel=1e-5, abs=1e-4)


@settings(max_examples=40, derandomize=True)
@given(st.floats(0.0, 0.6), st.floats(-0.3, 0.3), st.floats(-0.4, 0.4))
def test_prediction_follows_an_arc(v, omega, bearing):
    thing = 4.0 * np.cos(bearing), 4.0 * np.sin(bearing)
    e, depth = seen_from(np.zeros(3), thing)
    speeds = np.full((1, 11), v), np.full((1, 11), omega)
    predicted_e, predicted_depth = predict(ImageTarget(e + CAMERA.centre[0], depth), *speeds, 0.2, CAMERA)
    t = 0.2 * np.arange(11)
    heading = omega * t
    x = v * t * np.sinc(heading / np.pi / 2) * np.cos(heading / 2)
    y = v * t * np.sinc(heading / np.pi / 2) * np.sin(heading / 2)
    exact = np.array([seen_from(pose, thing) for pose in np.column_stack([x, y, heading])])
    inside = np.abs(exact[:, 0]) < CAMERA.width / 2
    np.testing.assert_allclose(predicted_e[0, inside], exact[inside, 0], atol=1.0)
    np.testing.assert_allclose(predicted_depth[0, inside], exact[inside, 1], atol=0.02)


@given(st.floats(1.0, 5.0), st.floats(-0.6, 0.6), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.8, 0.8))
def test_a_still_object_is_seen_elsewhere_after_a_motion(distance, bearing, x, y, turn):
    thing = CAMERA.ahead + distance * np.cos(bearing), distance * np.sin(bearing)
    e, depth = seen_from(np.zeros(3), thing)
    found = seen_after(ImageTarget(e + CAMERA.centre[0], depth), np.array([x, y, turn]), CAMERA)
    exact_e, exact_depth = seen_from(np.array([x, y, turn]), thing)
    if exact_depth > 0.1:
        assert (found.u - CAMERA.centre[0], found.depth) == pytest.approx((exact_e, exact_depth), abs=1e-6)
    else:
        assert found.depth == pytest.approx(0.1) and np.isfinite(found.u)


def test_prediction_stays_finite_when_the_robot_drives_through_the_object():
    e, depth = predict(ImageTarget(200.0, 0.6), np.full((1, 26), 0.6), np.full((1, 26), 1.5), 0.2, CAMERA)
    assert np.isfinite(e).all() and (depth >= 0.1).all()


def test_cost_rewards_centring_and_approaching_until_the_threshold():
    config = CentringConfig()

    def cost(e, z):
        return centring_cost(np.array([e], float), np.array([z], float), CAMERA, config)[0]

    assert (cost([60, 30, 0], [3, 3, 3]) < 0).all()
    assert (cost([0, 30, 60], [3, 3, 3]) > 0).all()
    assert (cost([0, 0, 0], [3, 2, 1.5]) < 0).all()  # Eq. 5 corrected
    assert (cost([0, 0], [1.5, 1.2]) > 0).all()
    assert cost([60, 0], [2, 2]).sum() == pytest.approx(-config.orient_weight * (60 / CAMERA.focal) ** 2)


def test_centred():
    u0 = CAMERA.centre[0]
    assert centred(ImageTarget(u0 + 5, 2.0), CAMERA, CentringConfig())
    assert not centred(ImageTarget(u0 + 9, 2.0), CAMERA, CentringConfig())
