"""Distance to go against a dense sampling of the path."""

import numpy as np
import pytest

from edge.planning.control_law import ControlLawConfig, roll_out
from edge.planning.path_progress import PathProgress, ProgressConfig, distance_to_go

PATH = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.5], [4.0, 3.0]])
LENGTH = 2.0 + 1.5 + 2.5


def dense(path, count=20001):
    arc = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    s = np.linspace(0, arc[-1], count)
    return s, np.column_stack([np.interp(s, arc, path[:, 0]), np.interp(s, arc, path[:, 1])])


def test_projection_equals_brute_force():
    rng = np.random.default_rng(0)
    points = rng.uniform((-1, -1), (5, 4), (200, 2))
    s, on_path = dense(PATH)
    to_go, beside = PathProgress(PATH, (0, 0), 100.0).project(*points.T)
    distance = np.hypot(*(points[:, None] - on_path).transpose(2, 0, 1))
    np.testing.assert_allclose(beside, distance.min(axis=1), atol=1e-3)
    certain = np.array([np.ptp(s[row <= row.min() + 1e-3]) < 0.3 for row in distance])  # else two parts are as near
    assert certain.sum() > 150
    np.testing.assert_allclose(to_go[certain], LENGTH - s[distance.argmin(axis=1)][certain], atol=2e-3)


def test_only_the_part_within_reach_counts():
    hairpin = np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 0.4], [0.0, 0.4]])
    to_go, _ = PathProgress(hairpin, (0.0, 0.0), 3.0).project(1.0, 0.35)
    assert to_go == pytest.approx(9.4)  # not 1.0, on the way back
    assert PathProgress(hairpin, (0.0, 0.0), 20.0).project(1.0, 0.35)[0] == pytest.approx(1.0)


def test_poses_ahead():
    progress = PathProgress(PATH, (1.5, 0.1), 3.0)
    assert progress.travelled == pytest.approx(1.5)
    np.testing.assert_allclose(
        progress.ahead([0.25, 1.0, 99.0]),
        [[1.75, 0, 0], [2.0, 0.5, np.pi / 2], [4.0, 3.0, np.arctan2(1.5, 2.0)]],
    )


def test_path_of_one_place():
    progress = PathProgress(np.array([[1.0, 2.0], [1.0, 2.0]]), (0, 0), 3.0)
    to_go, beside = progress.project(np.array([1.0, 4.0]), np.array([2.0, 6.0]))
    np.testing.assert_allclose(to_go, 0.0)
    np.testing.assert_allclose(beside, [0.0, 5.0])
    np.testing.assert_allclose(progress.ahead([0.5])[0, :2], [1.0, 2.0])


def test_final_heading_counts_near_the_end_only_and_not_at_it():
    config, law = ProgressConfig(), ControlLawConfig()
    progress = PathProgress(np.array([[0.0, 0.0], [3.0, 0.0]]), (0, 0), 9.0)

    def extra(x):
        still = roll_out((x, 0.0, 0.0), (0, 0), np.array([[x, 0.0, 0.0, 0.0]]), 0.1, law)
        plain = distance_to_go(still, progress, None, config)
        return float((distance_to_go(still, progress, 1.0, config) - plain)[0, 0])

    assert extra(2.7) > 0.05
    assert extra(0.0) < 0.01
    assert extra(3.0) == 0.0
