import numpy as np
import pytest

from firmware_sim.odometry import Odometry, OdometryConfig

PERIOD = 0.02
TICKS = 2_000_000  # so fine that counts hardly round


def run(odometry, left, right, seconds, gyro_bias=0.0, ticks=(0, 0)):
    """Feed wheels turning at ``left``, ``right`` [m/s]; returns the counts at the end."""
    per_metre = TICKS / (2 * np.pi * 0.05)
    start = np.array(ticks)
    for i in range(1, round(seconds / PERIOD) + 1):
        counts = start + np.round(np.array([left, right]) * per_metre * i * PERIOD)
        ticks = (int(counts[0]), int(counts[1]))
        odometry.update(ticks, (right - left) / 0.28 + gyro_bias)
    return ticks


def make():
    return Odometry(OdometryConfig(), 0.05, 0.28, TICKS, PERIOD)


@pytest.mark.parametrize("left, right", [(0.4, 0.4), (0.3, 0.4), (-0.1, 0.1), (-0.3, -0.2)])
def test_equals_the_closed_form_arc_without_noise(left, right):
    odometry = make()
    run(odometry, left, right, 6.0)
    v, omega = (left + right) / 2, (right - left) / 0.28
    theta = omega * 6.0
    if omega:
        expected = [v / omega * np.sin(theta), v / omega * (1 - np.cos(theta))]
    else:
        expected = [v * 6.0, 0.0]
    np.testing.assert_allclose(odometry.pose[:2], expected, atol=5e-3)
    assert np.cos(odometry.pose[2] - theta) == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(odometry.twist, [v, omega], atol=1e-3)


def test_learns_the_gyro_bias_at_rest():
    odometry = make()
    ticks = run(odometry, 0.0, 0.0, 2.0, gyro_bias=0.01)
    run(odometry, 0.4, 0.4, 10.0, gyro_bias=0.01, ticks=ticks)
    assert abs(odometry.pose[2]) < 0.005


def test_covariance_grows_with_the_way_and_stays_symmetric():
    odometry = make()
    ticks = run(odometry, 0.4, 0.4, 2.0)
    near = odometry.covariance
    run(odometry, 0.4, 0.4, 10.0, ticks=ticks)
    far = odometry.covariance
    assert (np.diag(far) > np.diag(near)).all()
    np.testing.assert_allclose(far, far.T, atol=1e-12)
    assert (np.linalg.eigvalsh(far) > -1e-12).all()
