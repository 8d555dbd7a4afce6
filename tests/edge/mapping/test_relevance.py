"""The Gaussian of a cell against the product of densities, and where a view counts at all."""

import numpy as np
import pytest
from scipy.stats import norm

from edge.camera import CameraModel
from edge.mapping.relevance import RelevanceConfig, RelevanceMap
from edge.observation import LaserScan
from tests.edge.mapping.test_coverage import FRAME, OPEN, around

CAMERA = CameraModel()
AHEAD = np.zeros(3)
WALL = np.full((240, 320), 2.0, np.float32)  # a wall 2 m ahead
OPEN_SCAN = LaserScan(0.0, np.full(360, 7.0), -np.pi, 0.017, 8.0, np.zeros(3))


def at(relevance, x, y):
    cell = relevance.frame.to_cell([x, y])
    return float(relevance.mean[cell]), float(relevance.variance[cell])


def looked(*views, config=None):
    relevance = RelevanceMap(config)
    for prompts, pose in views:
        relevance.integrate(np.array(pose, float), WALL, prompts, CAMERA, OPEN)
    return relevance


def test_two_looks_ahead_make_the_product_of_three_gaussians():
    first, second = [0.2, 0.3, 0.4], [0.7, 0.8]
    found = looked((first, AHEAD), (second, AHEAD))
    x = np.linspace(-3, 4, 70_001)
    density = norm.pdf(x, 0.5, np.sqrt(0.5))
    for prompts in (first, second):
        density *= norm.pdf(x, np.mean(prompts), np.std(prompts))
    density /= density.sum()
    mean = (x * density).sum()
    assert at(found, 1.5, 0.0) == pytest.approx((mean, ((x - mean) ** 2 * density).sum()), rel=3e-2)


def test_the_order_of_looks_does_not_matter():
    views = [([0.2, 0.4], AHEAD), ([0.9, 0.7], (0.3, 0.2, 0.4)), ([0.5, 0.6], (-0.5, 0.0, -0.2))]
    one, other = looked(*views), looked(*reversed(views))
    assert one.mean == pytest.approx(other.mean, abs=1e-5) and one.variance == pytest.approx(other.variance, abs=1e-5)


def test_what_a_wall_hides_or_the_picture_does_not_show_keeps_the_prior():
    found = looked(([0.9, 0.8], AHEAD))
    for x, y in ((2.4, 0.0), (-1.0, 0.0), (0.5, 1.5)):
        assert at(found, x, y) == pytest.approx((0.5, 0.5))


def test_confidence_falls_to_the_edge_of_the_picture_and_by_half_halfway():
    config = RelevanceConfig(off_axis=0.2)
    found = looked(([0.9, 0.7], AHEAD), config=config)
    spread = 0.01
    for share, confidence in ((0.0, 1.0), (0.5, 0.5), (0.95, 0.0)):
        bearing = share * CAMERA.hfov / 2
        row, col = found.frame.to_cell([CAMERA.ahead + 1.8 * np.cos(bearing), 1.8 * np.sin(bearing)])
        variance = found.variance[row - 1 : row + 2, col - 1 : col + 2].mean()  # no cell's centre lies just there
        noise = spread + 0.2 * (1 - confidence)
        assert variance == pytest.approx(0.5 * noise / (0.5 + noise), rel=0.1)


def test_prompts_that_agree_say_more_than_prompts_that_do_not():
    agreed, split = looked(([0.6, 0.61], AHEAD)), looked(([0.2, 1.0], AHEAD))
    assert at(agreed, 1.5, 0.0)[1] < at(split, 1.5, 0.0)[1]
    assert at(looked(([0.6], AHEAD)), 1.5, 0.0)[1] > 0


def test_beliefs_stay_in_place_when_the_grid_grows():
    found = looked(([0.9, 0.8], AHEAD))
    before = at(found, 1.5, 0.0)
    grown = around(np.inf)
    scan_pose = np.array([-6.0, 6.0, 0.0])
    grown.integrate_scan(scan_pose, OPEN_SCAN)
    found.follow(grown.frame)
    assert found.frame != FRAME and at(found, 1.5, 0.0) == before and at(found, -6.0, 6.0) == (0.5, 0.5)


def test_around_takes_the_median_of_a_disc():
    found = looked(([0.9, 0.8], AHEAD))
    found.mean[found.frame.to_cell([1.0, 0.0])] = 100.0  # one cell gone mad
    mean, variance = found.around([1.0, 0.0], 0.3)
    assert mean == pytest.approx(0.85, abs=0.01) and 0 < variance < 0.1
