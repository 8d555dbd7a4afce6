import numpy as np

from edge.memory.motion import MotionNoise


def test_the_floor_holds_for_no_motion():
    noise = MotionNoise()
    np.testing.assert_allclose(np.linalg.inv(noise.information(np.zeros(3))), np.diag([0.01**2, 0.01**2, 0.005**2]))


def test_longer_motion_is_known_less_well():
    noise = MotionNoise()
    near, far = noise.information(np.array([0.3, 0.4, 0.1])), noise.information(np.array([3.0, 4.0, -1.0]))
    assert (np.diag(far) < np.diag(near)).all()
