"""Theta* against networkx on the grid graph, and its lines against brute-force sampling."""

from math import hypot

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.mapping.grid import GridFrame
from edge.planning.theta_star import ThetaStarConfig, _Search, plan

RESOLUTION = 0.05


def frame_of(grid):
    return GridFrame((-1.0, 2.0), RESOLUTION, grid.shape)


def length(path):
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def grid_graph(grid):
    """8-connected, diagonal only when both side cells are free."""
    graph = networkx.Graph()
    rows, cols = grid.shape
    for r, c in zip(*np.nonzero(grid)):
        graph.add_node((r, c))
        for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
            r2, c2 = r + dr, c + dc
            if 0 <= r2 < rows and 0 <= c2 < cols and grid[r2, c2] and grid[r, c2] and grid[r2, c]:
                graph.add_edge((r, c), (r2, c2), weight=hypot(dr, dc) * RESOLUTION)
    return graph


def assert_clear(path, grid, frame):
    """Samples every 0.5 mm of each line lie in traversable cells, up to 0.01 mm from a border."""
    for a, b in zip(path[:-1], path[1:]):
        t = np.linspace(0, 1, 2 + int(hypot(*(b - a)) / 5e-4))[:, None]
        for shift in ((1e-5, 0), (-1e-5, 0), (0, 1e-5), (0, -1e-5)):
            row, col = frame.to_cell(a + t * (b - a) + shift)
            assert grid[row, col].all()


@st.composite
def mazes(draw):
    rows, cols = draw(st.integers(4, 26)), draw(st.integers(4, 26))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    grid = rng.random((rows, cols)) > draw(st.floats(0.0, 0.45))
    cells = np.argwhere(grid)
    if len(cells) == 0:
        grid[0, 0] = True
        cells = np.argwhere(grid)
    return grid, tuple(cells[rng.integers(len(cells))]), tuple(cells[rng.integers(len(cells))])


@settings(max_examples=150, deadline=None, derandomize=True)
@given(mazes(), st.booleans(), st.sampled_from([0.05, 0.10]))
def test_agrees_with_networkx_on_random_mazes(maze, with_clearance, lattice):
    grid, start, goal = maze
    frame = frame_of(grid)
    graph = grid_graph(grid)
    clearance = np.full(grid.shape, 0.1) if with_clearance else None
    config = ThetaStarConfig(start_tolerance=0.0, goal_tolerance=0.0, lattice=lattice)
    path = plan(grid, frame, frame.to_world(*start), frame.to_world(*goal), clearance, config)
    if not networkx.has_path(graph, start, goal):
        assert path is None
        return
    shortest = networkx.dijkstra_path_length(graph, start, goal)
    straight = hypot(*(np.subtract(goal, start))) * RESOLUTION
    np.testing.assert_allclose(path[[0, -1]], [frame.to_world(*start), frame.to_world(*goal)], atol=1e-12)
    assert length(path) >= straight - 1e-9
    assert length(path) <= shortest * 1.05 + (1e-9 if lattice == RESOLUTION else 0.2)
    assert_clear(path, grid, frame)


def test_is_rarely_longer_than_the_grid_path():
    rng = np.random.default_rng(5)
    every_cell = ThetaStarConfig(lattice=RESOLUTION)
    ratios = []
    for _ in range(60):
        grid = rng.random((30, 30)) > 0.3
        graph = grid_graph(grid)
        cells = np.argwhere(grid)
        start, goal = (tuple(cells[rng.integers(len(cells))]) for _ in range(2))
        if start != goal and networkx.has_path(graph, start, goal):
            ends = frame_of(grid).to_world(*start), frame_of(grid).to_world(*goal)
            path = plan(grid, frame_of(grid), *ends, config=every_cell)
            ratios.append(length(path) / networkx.dijkstra_path_length(graph, start, goal))
    assert np.mean(np.array(ratios) <= 1 + 1e-9) > 0.95
    assert np.mean(ratios) < 0.98


@settings(max_examples=150, deadline=None, derandomize=True)
@given(mazes())
def test_line_of_sight_equals_brute_force_supercover(maze):
    """A cell belongs to the line when the line comes within its square, corners included."""
    grid, (r0, c0), (r1, c1) = maze
    rows, cols = np.indices(grid.shape)
    t0, t1 = np.zeros(grid.shape), np.ones(grid.shape)  # clip the line to each closed square (slab method)
    for start, stop, cell in ((r0, r1, rows), (c0, c1, cols)):
        low, high = cell - 0.5, cell + 0.5
        if start == stop:
            outside = (start < low) | (start > high)
            t0[outside] = 2.0
        else:
            near, far = (low - start) / (stop - start), (high - start) / (stop - start)
            t0, t1 = np.maximum(t0, np.minimum(near, far)), np.minimum(t1, np.maximum(near, far))
    touched = t0 <= t1 + 1e-9
    if r0 == r1 or c0 == c1:
        assert touched.sum() == abs(r1 - r0) + abs(c1 - c0) + 1
    search = _Search(grid, None)
    width = search.width
    cost = search._line_cost((r0 + 1) * width + c0 + 1, (r1 + 1) * width + c1 + 1)
    assert np.isfinite(cost) == bool(grid[touched].all())


def test_open_space_is_one_straight_line():
    grid = np.ones((80, 80), bool)
    path = plan(grid, frame_of(grid), (-0.5, 2.3), (2.4, 5.1))
    np.testing.assert_allclose(path, [[-0.5, 2.3], [2.4, 5.1]])


def test_one_cell_wide_door_between_lattice_nodes_is_found():
    for column in (20, 21):
        grid = np.ones((60, 60), bool)
        grid[30] = False
        grid[30, column] = True
        frame = frame_of(grid)
        path = plan(grid, frame, frame.to_world(5, 5), frame.to_world(55, 50))
        assert_clear(path, grid, frame)


def test_route_does_not_depend_on_where_the_lattice_falls():
    """A narrow, slanting passage is the short way; from every start near by the path takes it."""
    grid = np.ones((80, 120), bool)
    grid[8:, 40:70] = False
    for i in range(30):
        grid[40 + i // 2 : 42 + i // 2, 40 + i] = True
    frame = frame_of(grid)
    goal = frame.to_world(60, 100)
    lengths = [length(plan(grid, frame, frame.to_world(40 + i, 20 + j), goal)) for i in range(4) for j in range(4)]
    assert np.ptp(lengths) < 0.4
    every_cell = plan(grid, frame, frame.to_world(40, 20), goal, config=ThetaStarConfig(lattice=RESOLUTION))
    assert lengths[0] < length(every_cell) + 0.05


def test_ends_snap_within_the_tolerance_only_and_to_the_connected_side():
    grid = np.ones((60, 60), bool)
    grid[:, 30:33] = False  # a wall; the goal lies in it, nearer to the far side
    frame = frame_of(grid)
    start, goal = frame.to_world(10, 5), frame.to_world(10, 32)
    path = plan(grid, frame, start, goal)
    assert path[-1, 0] < frame.to_world(10, 30)[0]
    assert plan(grid, frame, start, goal, config=ThetaStarConfig(goal_tolerance=0.1)) is None
    assert plan(grid, frame, goal, start) is not None
    assert plan(grid, frame, goal, start, config=ThetaStarConfig(start_tolerance=0.0)) is None
    assert plan(grid, frame, start, (50.0, 50.0)) is None
    assert plan(grid, frame, (-50.0, 50.0), start) is None


def test_start_at_the_goal_is_a_path_of_no_length():
    grid = np.ones((20, 20), bool)
    path = plan(grid, frame_of(grid), (-0.5, 2.5), (-0.5, 2.5))
    assert path.shape == (2, 2) and length(path) == 0.0


def test_clearance_keeps_the_path_away_from_walls():
    grid = np.zeros((60, 120), bool)
    grid[1:-1, 1:-1] = True
    grid[1:30, 60] = False
    frame = frame_of(grid)
    blocked = np.argwhere(~grid)
    cells = np.stack(np.indices(grid.shape), axis=-1)
    clearance = np.full(grid.shape, np.inf)
    for row, col in blocked:
        np.minimum(clearance, np.hypot(cells[..., 0] - row, cells[..., 1] - col) * RESOLUTION, out=clearance)
    start, goal = frame.to_world(10, 10), frame.to_world(10, 110)

    def nearest(path):
        points = np.concatenate([a + np.linspace(0, 1, 100)[:, None] * (b - a) for a, b in zip(path[:-1], path[1:])])
        return clearance[frame.to_cell(points)].min()

    short, safe = plan(grid, frame, start, goal), plan(grid, frame, start, goal, clearance)
    assert nearest(short) <= 0.06
    assert nearest(safe) >= 0.3
    assert length(short) < length(safe) < 1.2 * length(short)


@pytest.mark.parametrize("seed", range(3))
def test_is_deterministic(seed):
    rng = np.random.default_rng(seed)
    grid = rng.random((60, 60)) > 0.2
    grid[0] = grid[-1] = grid[:, 0] = True
    frame = frame_of(grid)
    paths = [plan(grid, frame, frame.to_world(0, 0), frame.to_world(59, 59)) for _ in range(2)]
    assert (paths[0] is None and paths[1] is None) or np.array_equal(*paths)
