import numpy as np
import pytest

from edge.mapping.grid import GridFrame
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.warp import sources, warped
from edge.observation import LaserScan
from edge.pose import compose, transform

FRAME = GridFrame((-5.0, -4.0), 0.05, (160, 200))


def nodes(rng, count=12):
    return np.column_stack([rng.uniform(-4, 4, count), rng.uniform(-3, 3, count), rng.uniform(-3, 3, count)])


def test_nodes_that_stay_leave_the_map_as_it_is():
    rng = np.random.default_rng(0)
    layer, poses = rng.integers(-9, 9, FRAME.shape).astype(np.int8), nodes(rng)
    np.testing.assert_array_equal(warped(layer, *sources(FRAME, poses, poses)), layer)


@pytest.mark.parametrize("correction", [(0.4, -0.25, 0.0), (0.2, 0.1, 0.15)])
def test_nodes_that_move_as_one_move_the_map_rigidly(correction):
    rng = np.random.default_rng(1)
    before = nodes(rng)
    after = compose(np.array(correction), before)
    column, row = sources(FRAME, before, after)
    rows, cols = np.meshgrid(np.arange(20, 140, 7), np.arange(20, 180, 7), indexing="ij")
    old = np.column_stack([column[rows, cols].ravel(), row[rows, cols].ravel()])
    old_points = FRAME.to_world(old[:, 1], old[:, 0])
    np.testing.assert_allclose(transform(correction, old_points), FRAME.to_world(rows.ravel(), cols.ravel()), atol=2e-3)


def test_each_end_of_a_map_goes_with_its_own_nodes():
    before = np.array([[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    after = before + [[0.0, 0.0, 0.0], [0.0, 0.5, 0.0]]
    layer = np.zeros(FRAME.shape, np.int8)
    layer[80, 20] = layer[80, 180] = 5  # y = 0 at x = -4 and x = 4
    rows, cols = np.nonzero(warped(layer, *sources(FRAME, before, after)))
    assert sorted(zip(cols.tolist(), rows.tolist())) == [(20, 80), (180, 90)]


def test_a_grid_moves_with_its_layers():
    grid, pose = OccupancyGrid(), np.zeros(3)
    scan = LaserScan(0.0, np.full(360, 2.0, np.float32), -np.pi, 2 * np.pi / 360, 8.0, pose)
    grid.integrate_scan(pose, scan)
    moved = OccupancyGrid()
    moved.integrate_scan(np.array([0.5, -0.2, 0.0]), scan)
    before = grid.to_bytes()
    other, *_ = grid.moved(pose[None], np.array([[0.5, -0.2, 0.0]]))
    assert grid.to_bytes() == before

    def cells(g):
        rows, cols = np.nonzero(g.occupied)
        return {tuple(cell) for cell in np.round(g.frame.to_world(rows, cols), 3).tolist()}

    assert cells(other) == cells(moved)


def test_walls_far_from_a_node_that_turns_are_not_cut_off():
    grid, pose = OccupancyGrid(), np.zeros(3)
    walls = np.full(720, 6.1, np.float32)
    grid.integrate_scan(pose, LaserScan(0.0, walls, -np.pi, 2 * np.pi / 720, 8.0, pose))
    shape = grid.frame.shape
    shifted = OccupancyGrid.from_bytes(grid.to_bytes())
    for turned in (np.radians(10), np.radians(45)):
        before = np.array([[2.0, -2.0, 0.0]])
        other, *_ = shifted.moved(before, before + [0.0, 0.0, turned])
        assert other.occupied.sum() == pytest.approx(grid.occupied.sum(), rel=0.1)
    assert other.frame.shape > shape
