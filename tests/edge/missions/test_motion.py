"""The geometry behind the motions."""

import numpy as np
import pytest

from edge.missions.motion import length, resample

PATH = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.55]])


def test_resampled_points_lie_on_the_path_and_keep_its_ends():
    points = resample(PATH, 0.1)
    assert np.array_equal(points[0], PATH[0]) and np.array_equal(points[-1], PATH[-1])
    assert ((points[:, 1] == 0) | (points[:, 0] == 1)).all()
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 0.1 + 1e-9
    assert length(points) == pytest.approx(length(PATH)) == pytest.approx(1.55)
