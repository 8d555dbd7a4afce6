"""Survival and expected cost on hand-made trajectories; clearance look-up against scipy's interpolation."""

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from edge.mapping.grid import GridFrame
from edge.planning.control_law import RollOuts
from edge.planning.trajectory_cost import CostConfig, expected_cost, look_up, survival

CONFIG = CostConfig()
FRAME = GridFrame((-1.0, 2.0), 0.05, (60, 80))


def line(x0, y0, v, steps=25):
    """Trajectory along x at constant speed."""
    t = 0.2 * np.arange(steps + 1)[None]
    zero = np.zeros_like(t)
    return RollOuts(x0 + v * t, y0 + zero, zero, v + zero, zero, np.array([[v, 0.0]]))


def wall_at(x):
    """Clearance of a grid with a wall along y at ``x``."""
    cells = FRAME.to_world(*np.indices(FRAME.shape))
    return np.abs(cells[..., 0] - x).astype(np.float32)


def test_look_up_is_bilinear_between_cell_centres():
    rng = np.random.default_rng(0)
    clearance = rng.random(FRAME.shape)
    rows, cols = np.arange(60), np.arange(80)
    y, x = FRAME.to_world(rows, rows)[:, 1], FRAME.to_world(cols, cols)[:, 0]
    expected = RegularGridInterpolator((y, x), clearance)
    points = rng.uniform((x[0], y[0]), (x[-1] - 0.001, y[-1] - 0.001), (300, 2))
    np.testing.assert_allclose(look_up(clearance, FRAME, *points.T), expected(points[:, ::-1]), atol=1e-9)


def test_outside_the_grid_there_is_no_clearance():
    clearance = np.ones(FRAME.shape)
    np.testing.assert_array_equal(look_up(clearance, FRAME, np.array([-1.1, 0.0, 9.0]), np.array([3.0, 1.0, 3.0])), 0.0)


def test_survival_equals_the_product_of_the_paper():
    out = line(0.0, 3.0, 0.4)
    clearance = wall_at(1.6)
    alive = 1.0
    expected = []
    sigma = 0.02 + 0.04 * 0.4 / 0.6
    for x in out.x[0, 1:]:
        d = max(0.0, abs(1.6 - x) - (0.18 + 0.02 + CONFIG.margin_per_speed * 0.4))
        alive *= 1 - np.exp(-((d / sigma) ** 2))
        expected.append(alive)
    np.testing.assert_allclose(survival(out, clearance, FRAME, CONFIG)[0], expected, atol=0.02)
    assert expected[0] > 0.99 and expected[-1] == 0.0


def test_standing_too_near_is_survived_and_leaving_is_too_but_coming_nearer_is_not():
    clearance = wall_at(1.0)
    leaving, staying, nearing = (survival(line(0.81, 3.0, v), clearance, FRAME, CONFIG)[0] for v in (-0.2, 0.0, 0.2))
    assert leaving[-1] > 0.9 and staying[-1] > 0.9 and nearing[1] < 0.4 and nearing[-1] < 1e-6


def test_cost_is_the_discounted_sum_of_its_parts():
    out = line(0.0, 3.0, 0.5)
    alive = np.linspace(1.0, 0.4, 25)[None]
    gain = np.full((1, 25), -0.1)
    expected = sum(
        0.97**i * (p * -0.1 + 0.2 * CONFIG.v_weight * 0.25 + (1 - p) * CONFIG.collision * 1.5)
        for i, p in enumerate(alive[0])
    )
    assert expected_cost(out, alive, gain, 0.2, CONFIG)[0] == pytest.approx(expected)


def test_room_once_gained_is_not_given_up_again():
    """From inside an obstacle of the map (a phantom), out of it, and into a real one."""
    clearance = np.minimum(wall_at(0.0), wall_at(1.5))
    alive = survival(line(0.0, 3.0, 0.3), clearance, FRAME, CONFIG)[0]
    assert alive[9] > 0.5  # half-way, 0.6 m on
    assert alive[-1] < 1e-6
