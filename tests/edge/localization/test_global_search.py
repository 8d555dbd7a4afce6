"""Places for a scan in the map of a home: the true one is among them, and few others fit as well."""

import numpy as np
import pytest

from edge.localization.global_search import candidates
from edge.localization.likelihood_field import LikelihoodField
from edge.localization.scan_matching import scan_points
from edge.mapping.occupancy import OccupancyGrid
from edge.pose import transform, wrap
from tests.edge.localization.test_scan_matching import places


@pytest.fixture(scope="module")
def search(boxes_map):
    grid, _, _ = boxes_map
    field = LikelihoodField.around(grid, np.array([4.0, 3.5]), 20.0)
    return lambda scan: candidates(grid, field, scan_points(scan, 0.1)), field


def test_the_true_place_is_among_them(boxes_map, scan, search):
    _, tour, lidar = boxes_map
    for pose in places(tour, 20, seed=7)[0]:
        found = search[0](scan(lidar, pose))
        near = np.hypot(*(found - pose)[:, :2].T) < 0.2
        turned = np.abs(wrap(found[:, 2] - pose[2])) < np.radians(6)
        assert found.shape == (40, 3) and (near & turned).any()


def test_none_fits_better_than_those_handed_on(boxes_map, scan, search):
    grid, tour, lidar = boxes_map
    points = scan_points(scan(lidar, places(tour, 1, seed=8)[0][0]), 0.1)
    points = points[:: max(1, len(points) // 90)]

    def fit(pose):
        distance, _, _ = search[1].sample(transform(pose, points))
        return np.exp(-0.5 * (distance / 0.2) ** 2).sum()

    rng = np.random.default_rng(3)
    free = grid.frame.to_world(*np.nonzero(grid.traversable(0.1)))
    others = np.column_stack([free[rng.choice(len(free), 500)], rng.integers(72, size=500) * np.radians(5)])
    worst = min(fit(pose) for pose in candidates(grid, search[1], points))
    assert np.mean([fit(pose) < worst for pose in others]) > 0.99


def test_a_map_without_free_ground_has_no_place(search):
    grid = OccupancyGrid()
    field = LikelihoodField.around(grid, np.zeros(2), 5.0)
    assert candidates(grid, field, np.ones((10, 2))).shape == (0, 3)
