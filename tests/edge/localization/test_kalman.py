import numpy as np
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.localization.kalman import PoseBelief
from edge.pose import compose, wrap

seeds = st.integers(0, 10**6)


def spread(rng, scale):
    root = rng.normal(0, scale, (3, 3))
    return root @ root.T + 1e-9 * np.eye(3)


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_correction_is_filterpys(seed):
    rng = np.random.default_rng(seed)
    belief, noise = PoseBelief(rng.normal(0, 1, 3), spread(rng, 0.1)), spread(rng, 0.1)
    measured = belief.mean + rng.normal(0, 0.2, 3)
    other = KalmanFilter(dim_x=3, dim_z=3)
    other.x, other.P, other.R, other.H = belief.mean.copy(), belief.covariance.copy(), noise, np.eye(3)
    other.update(measured)
    got = belief.corrected(measured, noise)
    np.testing.assert_allclose(got.mean, other.x, atol=1e-9)
    np.testing.assert_allclose(got.covariance, other.P, atol=1e-9)
    np.testing.assert_allclose(belief.distance(measured, noise), other.mahalanobis**2, rtol=1e-6)


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_prediction_is_filterpys_with_numeric_jacobians(seed):
    rng = np.random.default_rng(seed)
    belief, motion, noise = PoseBelief(rng.normal(0, 1, 3), spread(rng, 0.1)), rng.normal(0, 0.5, 3), spread(rng, 0.05)

    def slopes(function, at):
        return np.stack([(function(at + h) - function(at - h)) / 2e-6 for h in 1e-6 * np.eye(3)], axis=1)

    by_pose = slopes(lambda pose: compose(pose, motion), belief.mean)
    by_motion = slopes(lambda step: compose(belief.mean, step), motion)
    other = KalmanFilter(dim_x=3, dim_z=3)
    other.x, other.P = belief.mean.copy(), belief.covariance.copy()
    other.predict(F=by_pose, Q=by_motion @ noise @ by_motion.T)
    got = belief.moved(motion, noise)
    np.testing.assert_allclose(got.mean, compose(belief.mean, motion))
    np.testing.assert_allclose(got.covariance, other.P, atol=1e-6)


def test_headings_meet_across_the_wrap():
    belief = PoseBelief(np.array([0, 0, np.pi - 0.05]), np.eye(3))
    got = belief.corrected(np.array([0, 0, -np.pi + 0.05]), np.eye(3))
    assert abs(wrap(got.mean[2] - np.pi)) < 1e-9
    assert belief.distance(np.array([0, 0, -np.pi + 0.05]), np.eye(3)) < 0.01


def test_a_sure_measurement_wins_and_a_vague_one_changes_nothing():
    belief, measured = PoseBelief(np.zeros(3), 1e-2 * np.eye(3)), np.array([0.3, -0.2, 0.1])
    np.testing.assert_allclose(belief.corrected(measured, 1e-9 * np.eye(3)).mean, measured, atol=1e-6)
    np.testing.assert_allclose(belief.corrected(measured, 1e9 * np.eye(3)).mean, 0, atol=1e-6)
