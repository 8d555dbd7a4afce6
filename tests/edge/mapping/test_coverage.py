"""What counts as looked at: a fan in front of the camera, up to what blocks it and no farther than the range."""

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.coverage import BESIDE, CameraCoverage
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan

CAMERA = CameraModel()


def around(distance):
    """A map from one lidar turn in the middle of a round room; of nothing where that is inf."""
    grid = OccupancyGrid()
    ranges = np.full(360, distance, np.float32)
    grid.integrate_scan(np.zeros(3), LaserScan(0.0, ranges, -np.pi, 2 * np.pi / 360, 8.0, np.zeros(3)))
    return grid


OPEN = around(np.inf)
FRAME = OPEN.frame


def viewed(depth, pose=(0.0, 0.0, 0.0), grid=OPEN):
    coverage = CameraCoverage()
    coverage.integrate(np.array(pose), np.full((240, 320), depth, np.float32), CAMERA, grid)
    return lambda x, y: bool(coverage.viewed[grid.frame.to_cell([x, y])])


@pytest.mark.parametrize("depth", [0.0, np.nan, 5.0])
def test_open_space_is_viewed_up_to_the_range_and_not_beyond(depth):
    at = viewed(depth)
    assert at(1.0, 0.0) and at(2.95, 0.0) and not at(3.3, 0.0)


def test_a_wall_ends_the_view():
    at = viewed(1.5)
    assert at(1.5, 0.0) and not at(1.8, 0.0)


@pytest.mark.parametrize("depth", [0.0, np.nan])
def test_a_wall_too_near_for_the_sensor_ends_the_view_too(depth):
    at = viewed(depth, grid=around(0.45))
    assert at(0.3, 0.0) and not at(0.6, 0.0) and not at(1.5, 0.5)


@pytest.mark.parametrize("side", [1, -1])
def test_the_view_is_as_wide_as_the_camera_sees(side):
    at = viewed(5.0)
    inside, outside = np.radians(37), np.radians(42)
    assert at(0.1 + 2 * np.cos(inside), side * 2 * np.sin(inside))
    assert not at(0.1 + 2 * np.cos(outside), side * 2 * np.sin(outside))


def test_the_fan_turns_with_the_robot():
    at = viewed(5.0, pose=(1.0, -1.0, np.pi / 2))
    assert at(1.0, 1.5) and not at(3.0, -1.0)


def test_low_furniture_does_not_hide_what_rises_behind_it():
    depth = np.full((240, 320), 2.5, np.float32)
    depth[140:] = 1.0
    coverage = CameraCoverage()
    coverage.integrate(np.zeros(3), depth, CAMERA, OPEN)
    assert coverage.viewed[FRAME.to_cell([2.4, 0.0])]


def test_what_was_viewed_stays_when_the_grid_grows():
    grid, coverage = around(np.inf), CameraCoverage()
    coverage.integrate(np.zeros(3), np.full((240, 320), 2.0, np.float32), CAMERA, grid)
    before, small = int(coverage.viewed.sum()), grid.frame
    grid.integrate_scan(np.array([-6.0, 6.0, 0.0]), LaserScan(0.0, np.full(360, 7.0), -np.pi, 0.017, 8.0, np.zeros(3)))
    assert grid.frame != small
    coverage.integrate(np.array([0.0, 0.0, np.pi]), np.full((240, 320), 2.0, np.float32), CAMERA, grid)
    assert coverage.viewed[grid.frame.to_cell([1.5, 0.0])] and coverage.viewed[grid.frame.to_cell([-1.5, 0.0])]
    assert abs(int(coverage.viewed.sum()) - 2 * before) < 0.1 * before


def test_what_is_forgotten_must_be_looked_at_again():
    coverage, wall = CameraCoverage(), np.full((240, 320), 2.0, np.float32)
    coverage.integrate(np.zeros(3), wall, CAMERA, OPEN)
    assert coverage.viewed.any()
    coverage.forget()
    assert not coverage.viewed.any() and coverage.frame == FRAME
    coverage.integrate(np.zeros(3), wall, CAMERA, OPEN)
    assert coverage.viewed.any()


def half_seen():
    """A round wall 2 m away; the camera has looked at all of the floor, and at the half of the wall ahead."""
    grid, coverage = around(2.0), CameraCoverage()
    coverage.follow(grid.frame)
    ahead = grid.frame.to_world(*np.indices(grid.frame.shape))[..., 0] > 0
    coverage.viewed[grid.free | grid.occupied & ahead] = 1
    return grid, coverage


def test_the_floor_before_what_only_the_lidar_has_seen_is_not_explored():
    grid, coverage = half_seen()
    explored = coverage.explored(grid, 0.18)

    def at(x):
        return explored[tuple(grid.frame.to_cell([x, 0.01]))]

    assert at(1.9) and at(0.0) and at(-1.6)
    assert not at(-1.9) and not at(-1.75)  # as near as the robot gets to the wall
    assert not at(-2.2) and not at(2.2)


@pytest.mark.parametrize("seed", range(20))
def test_one_place_is_judged_as_in_the_whole_map(seed):
    grid, coverage = half_seen()
    rng, (rows, cols) = np.random.default_rng(seed), grid.frame.shape
    row, col = rng.integers(rows), rng.integers(cols) if seed % 2 else rng.choice([0, 3, cols - 4, cols - 1])
    place = grid.frame.to_world(row, col)
    coverage.viewed[:] = True  # the border of the map, too, though nobody knows what is there
    beside = coverage.explored(grid, 0.18)[
        max(row - BESIDE, 0) : row + BESIDE + 1, max(col - BESIDE, 0) : col + BESIDE + 1
    ]
    assert coverage.has_explored(grid, 0.18, place) == beside.all()
