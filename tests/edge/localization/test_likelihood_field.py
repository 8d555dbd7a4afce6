import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt, map_coordinates

from edge.localization.likelihood_field import LikelihoodField
from edge.mapping.occupancy import OccupancyGrid


def test_distances_are_scipys_up_to_the_reach(boxes_map):
    grid, _, _ = boxes_map
    field = LikelihoodField.around(grid, np.array([4.0, 3.5]), 20.0)
    assert field.frame.shape == grid.frame.shape and not field.empty
    exact = np.minimum(distance_transform_edt(grid.lidar <= 0) * grid.resolution, field.reach)
    np.testing.assert_allclose(field.distance, exact, rtol=0.025, atol=1e-6)


def test_samples_are_scipys_bilinear_interpolation(boxes_map):
    grid, _, _ = boxes_map
    field = LikelihoodField.around(grid, np.array([4.0, 3.5]), 3.0)
    rng = np.random.default_rng(0)
    points = rng.uniform([1.5, 1.0], [6.5, 6.0], (500, 2))
    value, slope, known = field.sample(points)
    cells = (points - field.frame.origin) / 0.05 - 0.5
    np.testing.assert_allclose(value, map_coordinates(field.distance, cells.T[::-1], order=1), atol=1e-5)
    step = 1e-7
    for axis in range(2):
        ahead = field.sample(points + step * np.eye(2)[axis])[0]
        smooth = np.abs(cells - np.rint(cells)).min(axis=1) > 1e-4
        np.testing.assert_allclose(slope[smooth, axis], ((ahead - value) / step)[smooth], atol=1e-3)
    assert known.mean() > 0.9


def test_the_window_is_where_it_says(boxes_map):
    grid, _, _ = boxes_map
    whole = LikelihoodField.around(grid, np.array([4.0, 3.5]), 20.0)
    part = LikelihoodField.around(grid, np.array([6.0, 2.0]), 1.5)
    assert max(part.frame.shape) <= 64
    points = np.random.default_rng(0).uniform([5.2, 1.2], [6.8, 2.8], (100, 2))
    near = whole.sample(points)[0] < 0.4  # further off, the nearest obstacle may lie outside the window
    np.testing.assert_allclose(part.sample(points)[0][near], whole.sample(points)[0][near], atol=1e-5)


def test_outside_it_is_flat_and_unknown(boxes_map):
    field = LikelihoodField.around(boxes_map[0], np.array([4.0, 3.5]), 1.0)
    value, slope, known = field.sample(np.array([[100.0, 0.0], [-100.0, -50.0], [4.0, 90.0]]))
    assert (value == field.reach).all() and not slope.any() and not known.any()


@pytest.mark.parametrize("centre", [(0.0, 0.0), (500.0, -500.0), (-500.0, 3.0)])
def test_an_empty_map_and_a_robot_far_outside_are_survived(centre):
    assert LikelihoodField.around(OccupancyGrid(), np.array(centre), 8.0).empty
