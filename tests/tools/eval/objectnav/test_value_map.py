"""The baseline's map, by the averages of its paper."""

import numpy as np
import pytest

from edge.mapping.grid import GridFrame
from tools.eval.objectnav.value_map import ValueMap


def test_what_was_not_seen_has_no_value_rather_than_0():
    found = ValueMap()
    found.frame = GridFrame((0.0, 0.0), 0.05, (40, 40))
    found.mean, found.variance = np.zeros((40, 40), np.float32), np.ones((40, 40), np.float32)
    assert found.around([1.0, 1.0], 0.5) == (0.0, 1.0)
    few = np.array([20, 20, 21]), np.array([20, 21, 20])
    found.fuse(few, np.array([0.7]), np.array([1.0, 1.0, 1.0]))
    assert found.around([1.0, 1.0], 0.5)[0] == pytest.approx(0.7)


def test_values_are_weighted_by_confidence():
    found = ValueMap()
    found.mean, found.variance = np.zeros((1, 2), np.float32), np.ones((1, 2), np.float32)
    cells = np.array([0, 0]), np.array([0, 1])
    found.fuse(cells, np.array([0.8]), np.array([1.0, 0.5]))
    found.fuse(cells, np.array([0.2]), np.array([0.5, 0.5]))
    assert found.mean[0] == pytest.approx([(0.8 + 0.5 * 0.2) / 1.5, 0.5])
    assert 1 - found.variance[0] == pytest.approx([1.25 / 1.5, 0.5])
