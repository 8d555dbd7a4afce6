import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from edge.perception.tracking import BoxTracker, TrackerConfig


def reference(config, start, dt):
    """The same filter in filterpy."""
    kalman = KalmanFilter(dim_x=4, dim_z=2)
    kalman.x = np.array([*start, 0.0, 0.0])
    kalman.P = np.diag([config.centre_noise**2] * 2 + [config.velocity_prior**2] * 2)
    kalman.F = np.eye(4) + dt * np.eye(4, k=2)
    kalman.H = np.eye(2, 4)
    kalman.R = np.eye(2) * config.centre_noise**2
    push = np.array([[dt**2 / 2, 0], [0, dt**2 / 2], [dt, 0], [0, dt]])
    kalman.Q = push @ push.T * config.acceleration**2
    return kalman


def test_it_equals_filterpy():
    config, dt = TrackerConfig(), 0.1
    rng = np.random.default_rng(1)
    path = np.array([160.0, 120.0]) + np.cumsum(rng.normal(0, 3, (40, 2)), 0)
    tracker, kalman = BoxTracker(config), reference(config, path[0], dt)
    tracker.update(0.0, tuple(path[0]))
    for k, measured in enumerate(path[1:], 1):
        seen = k % 5 != 0
        tracker.update(k * dt, tuple(measured) if seen else None)
        kalman.predict()
        if seen:
            kalman.update(measured)
        assert [*tracker.centre, *tracker.velocity] == pytest.approx(kalman.x, abs=1e-6)
        assert tracker.covariance == pytest.approx(kalman.P, abs=1e-6)


def test_it_follows_a_moving_object_more_closely_than_the_measurements():
    rng = np.random.default_rng(0)
    truth = np.stack([np.linspace(40, 280, 60), np.full(60, 120.0)], 1)
    measured = truth + rng.normal(0, 15, truth.shape)
    tracker = BoxTracker()
    estimated = np.array([tracker.update(0.1 * k, tuple(m)) for k, m in enumerate(measured)])
    error = np.linalg.norm(estimated - truth, axis=1)[20:].mean()
    assert error < 0.75 * np.linalg.norm(measured - truth, axis=1)[20:].mean()
    assert tracker.velocity[0] == pytest.approx(240 / 5.9, abs=15)


def test_of_a_still_object_before_a_turning_camera_it_is_surer_when_told_of_the_turn():
    rng, turned = np.random.default_rng(0), np.array([250.0 * np.sin(0.3 * k) for k in range(60)])  # px, to and fro
    noise = rng.normal(0, 15, 60)
    told, untold = BoxTracker(), BoxTracker()
    errors = np.empty((60, 2))
    for k in range(60):
        told.shift(turned[k] - turned[k - 1])
        for column, tracker in enumerate((told, untold)):
            errors[k, column] = tracker.update(0.1 * k, (160 + turned[k] + noise[k], 120.0))[0] - 160 - turned[k]
    rms = np.sqrt((errors[20:] ** 2).mean(axis=0))
    assert rms[0] < 0.7 * 15 and rms[0] < 0.3 * rms[1]


def test_a_jump_is_ignored():
    tracker = BoxTracker()
    for k in range(20):
        tracker.update(0.1 * k, (100.0, 100.0))
    assert tracker.update(2.0, (300.0, 30.0)) == pytest.approx((100, 100), abs=1)


def test_the_track_ends_when_nothing_fits_and_starts_anew():
    tracker = BoxTracker(TrackerConfig(max_age=1.0))
    for k in range(10):
        tracker.update(0.1 * k, (100.0, 100.0))
    assert tracker.update(2.5, None) is None
    assert tracker.velocity is None and not tracker.covariance.any()
    assert tracker.update(2.6, (300.0, 30.0)) == (300.0, 30.0)


def test_nothing_seen_is_no_track():
    assert BoxTracker().update(0.0, None) is None
