import numpy as np
import pytest
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import KalmanFilter

from edge.perception.constant_velocity import ConstantVelocity


@pytest.mark.parametrize("seed", range(5))
def test_it_is_filterpys_filter_at_uneven_times(seed):
    rng = np.random.default_rng(seed)
    noise, speed, acceleration = rng.uniform(0.02, 0.2), rng.uniform(0.3, 2), rng.uniform(0.2, 3)
    start = rng.normal(0, 3, 2)
    ours = ConstantVelocity(start, noise, speed, acceleration)
    theirs = KalmanFilter(dim_x=4, dim_z=2)
    theirs.x, theirs.P = np.array([*start, 0, 0]), np.diag([noise**2, noise**2, speed**2, speed**2])
    theirs.H = np.eye(2, 4)
    for _ in range(30):
        dt = rng.uniform(0.02, 0.4)
        ours.predict(dt)
        # filterpy orders each axis by itself: x, dx/dt, y, dy/dt.
        order = np.ix_([0, 2, 1, 3], [0, 2, 1, 3])
        q = Q_discrete_white_noise(2, dt, acceleration**2, block_size=2)[order]
        theirs.predict(F=np.eye(4) + dt * np.eye(4, k=2), Q=q)
        if rng.random() < 0.7:
            noise = rng.uniform(0.02, 0.2)
            measured = ours.position + rng.normal(0, 2 * noise, 2)
            distance = ours.distance(measured, noise)
            ours.correct(measured, noise)
            theirs.update(measured, R=noise**2)
            assert distance == pytest.approx(theirs.mahalanobis**2, rel=1e-6)
        np.testing.assert_allclose(ours.state, theirs.x, atol=1e-8)
        np.testing.assert_allclose(ours.covariance, theirs.P, atol=1e-8)
