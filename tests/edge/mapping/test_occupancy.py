import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from edge.camera import CameraModel
from edge.mapping.occupancy import OccupancyConfig, OccupancyGrid
from edge.observation import LaserScan

CAMERA = CameraModel()
CENTRE = np.array([0.0, 0.0, 0.3])


def at(grid, array, x, y):
    return array[tuple(int(index) for index in grid.frame.to_cell(np.array([x, y])))]


def turn(ranges, stamp=0.0):
    ranges = np.broadcast_to(np.asarray(ranges, np.float32), 360)
    return LaserScan(stamp, ranges, -np.pi, 2 * np.pi / 360, 8.0, np.zeros(3))


def test_one_scan_of_a_square_room(scan_of, walls_of):
    grid = OccupancyGrid()
    grid.integrate_scan(CENTRE, scan_of(CENTRE, walls_of(-2.02, -2.02, 2.02, 2.02)))
    rows, cols = np.nonzero(grid.occupied)
    centres = np.abs(grid.frame.to_world(rows, cols)).max(axis=1)
    assert len(rows) > 250 and np.abs(centres - 2.02).max() < 0.03
    inside = np.abs(grid.frame.to_world(*np.indices(grid.frame.shape))).max(axis=-1) < 1.95
    beyond = np.abs(grid.frame.to_world(*np.indices(grid.frame.shape))).max(axis=-1) > 2.03
    assert grid.free[inside].all() and grid.unknown[beyond & ~grid.occupied].all()
    assert (grid.free.astype(int) + grid.occupied + grid.unknown == 1).all()


def test_no_return_clears_and_a_lone_one_no_further_than_its_neighbours(scan_of):
    grid = OccupancyGrid()
    ranges = np.full(360, 2.0)
    ranges[180], ranges[90:100] = np.inf, np.inf  # beam 180 points ahead, 95 to the right
    grid.integrate_scan(np.zeros(3), turn(ranges))
    assert at(grid, grid.free, 1.5, 0) and at(grid, grid.unknown, 3.0, 0)
    assert at(grid, grid.free, 5.0 * np.cos(np.radians(-85)), 5.0 * np.sin(np.radians(-85)))


def test_a_leg_that_most_turns_pass_by_is_not_washed_out():
    """5 m away the beams are 9 cm apart: of the turns, each at its own heading, few meet a leg of 4 cm."""
    grid = OccupancyGrid()
    ranges = np.full(360, 7.0)
    ranges[180] = 5.02
    for _ in range(2):
        grid.integrate_scan(np.zeros(3), turn(ranges))
    for _ in range(20):
        grid.integrate_scan(np.array([0.0, 0.0, np.radians(0.5)]), turn(7.0))
    assert at(grid, grid.occupied, 5.02, 0.0)
    assert grid.free[tuple(grid.frame.to_cell(np.array([3.0, 0.0])))]


def test_nan_says_nothing():
    grid = OccupancyGrid()
    grid.integrate_scan(np.zeros(3), turn(np.nan))
    assert not grid.occupied.any() and grid.free.sum() <= 1


def test_a_removed_obstacle_is_cleared_and_a_new_one_shows():
    grid = OccupancyGrid()
    for _ in range(20):
        grid.integrate_scan(np.zeros(3), turn(1.0))
    assert at(grid, grid.occupied, 0.99, 0.01)
    for _ in range(10):
        grid.integrate_scan(np.zeros(3), turn(2.0))
    assert at(grid, grid.free, 0.99, 0.01) and at(grid, grid.occupied, 1.99, 0.01)
    for _ in range(3):
        grid.integrate_scan(np.zeros(3), turn(1.0))
    assert at(grid, grid.occupied, 0.99, 0.01)


def test_lidar_below_a_table_does_not_erase_its_top_nor_the_camera_its_leg(depth_of):
    grid = OccupancyGrid()
    table = (2.0, -0.6, 0.70, 3.0, 0.6, 0.74)
    grid.integrate_depth(np.zeros(3), depth_of(np.zeros(3), [table], CAMERA), CAMERA)
    assert at(grid, grid.occupied, 2.03, 0.01)
    for _ in range(30):
        grid.integrate_scan(np.zeros(3), turn(6.0))
    assert at(grid, grid.occupied, 2.03, 0.01)
    ranges = np.full(360, 6.0)
    ranges[180] = 3.52  # something too thin for the depth image
    for _ in range(3):
        grid.integrate_scan(np.zeros(3), turn(ranges))
    for _ in range(30):
        grid.integrate_depth(np.zeros(3), depth_of(np.zeros(3), [], CAMERA), CAMERA)
    assert at(grid, grid.occupied, 3.52, 0.0)
    assert at(grid, grid.free, 2.03, 0.01)  # the table is gone, and that the camera may say


def test_what_is_left_out_makes_no_hits_and_hides_what_is_behind(depth_of):
    grid, post = OccupancyGrid(), (2.0, -0.2, 0.0, 2.4, 0.2, 1.5)
    depth = depth_of(np.zeros(3), [post], CAMERA)
    for _ in range(10):
        grid.integrate_depth(np.zeros(3), depth, CAMERA, np.array([[2.2, 0.0, 0.4]]))
    assert not grid.occupied.any() and at(grid, grid.free, 1.7, 0.0) and not at(grid, grid.free, 2.6, 0.0)
    grid.integrate_depth(np.zeros(3), depth, CAMERA, np.array([[2.2, 1.0, 0.4]]))
    for _ in range(3):
        grid.integrate_depth(np.zeros(3), depth, CAMERA)
    assert at(grid, grid.occupied, 2.02, 0.0)


def test_a_stool_in_the_blind_zone_stays(depth_of):
    grid = OccupancyGrid()
    stool = (2.0, -0.2, 0.0, 2.4, 0.2, 0.35)
    grid.integrate_depth(np.zeros(3), depth_of(np.zeros(3), [stool], CAMERA), CAMERA)
    for x in np.arange(0.2, 1.5, 0.2):
        pose = np.array([x, 0.0, 0.0])
        depth = depth_of(pose, [stool], CAMERA)
        for _ in range(10):
            grid.integrate_depth(pose, depth, CAMERA)
        assert at(grid, grid.occupied, 2.02, 0.01)


def test_the_ground_under_the_robot_is_free():
    grid = OccupancyGrid()
    grid.integrate_depth(np.array([1.0, 1.0, 0.0]), np.zeros((240, 320), np.float32), CAMERA)
    assert at(grid, grid.free, 1.0, 1.0) and at(grid, grid.free, 1.08, 1.0) and at(grid, grid.unknown, 1.25, 1.0)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.floats(-30, 30), st.floats(-30, 30)), min_size=1, max_size=5))
def test_growing_keeps_what_was_known(places):
    grid = OccupancyGrid()
    for x, y in places:
        grid.integrate_scan(np.array([x, y, 0.0]), turn(1.0))
    for x, y in places:
        assert not at(grid, grid.unknown, x, y)
        row, col = grid.frame.to_cell(np.array([x + 0.999, y]))
        near = np.s_[int(row) - 1 : int(row) + 2, int(col) - 1 : int(col) + 2]
        assert not grid.unknown[near].all()
    assert (np.array(grid.frame.shape) % 64 == 0).all()
    # The same measurements in a grid that never has to grow.
    large = OccupancyGrid(config=OccupancyConfig(chunk=1000))
    for x, y in places:
        large.integrate_scan(np.array([x, y, 0.0]), turn(1.0))
    (x0, y0), (rows, cols) = grid.frame.origin, grid.frame.shape
    row, col = (int(i) for i in large.frame.to_cell(np.array([x0 + 1e-6, y0 + 1e-6])))
    np.testing.assert_array_equal(grid.lidar, large.lidar[row : row + rows, col : col + cols])


def test_clearance_against_scipy(scan_of, walls_of):
    grid = OccupancyGrid()
    assert grid.clearance().min() > 5.0  # nothing is in the way yet
    grid.integrate_scan(CENTRE, scan_of(CENTRE, np.concatenate([walls_of(-2, -3, 2, 3), walls_of(1, 1, 1.3, 1.5)])))
    exact = distance_transform_edt(~grid.occupied) * 0.05
    np.testing.assert_allclose(grid.clearance(), exact, rtol=0.025, atol=1e-6)
    assert (grid.traversable(0.3) == (grid.free & (grid.clearance() >= 0.3))).all()
    assert grid.clearance() is grid.clearance()
    before = grid.clearance()
    grid.integrate_scan(CENTRE, turn(1.0))
    assert grid.clearance() is not before


def test_saved_and_read_back(scan_of, walls_of, depth_of):
    grid = OccupancyGrid()
    grid.integrate_scan(CENTRE, scan_of(CENTRE, walls_of(-4, -3, 5, 3)))
    grid.integrate_depth(CENTRE, depth_of(CENTRE, [(2, -1, 0, 3, 1, 0.5)], CAMERA), CAMERA)
    back = OccupancyGrid.from_bytes(grid.to_bytes())
    assert back.frame == grid.frame
    np.testing.assert_array_equal(back.lidar, grid.lidar)
    np.testing.assert_array_equal(back.depth, grid.depth)
    back.integrate_scan(CENTRE, turn(1.0))
    with pytest.raises(ValueError, match="map the home again"):
        OccupancyGrid.from_bytes(grid.to_bytes()[:-3])


@pytest.mark.parametrize("pose", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0)])
def test_a_broken_pose_is_refused_and_the_map_kept(pose):
    grid = OccupancyGrid()
    grid.integrate_scan(np.zeros(3), turn(1.0))
    kept = grid.to_bytes()
    with pytest.raises(ValueError, match="three finite numbers"):
        grid.integrate_scan(np.array(pose), turn(1.0))
    with pytest.raises(ValueError, match="three finite numbers"):
        grid.integrate_depth(np.array(pose), np.zeros((240, 320), np.float32), CAMERA)
    with pytest.raises(ValueError, match="check the robot's pose"):
        grid.integrate_scan(np.array([5000.0, 0, 0]), turn(1.0))
    assert grid.to_bytes() == kept


def test_views_cannot_be_written():
    grid = OccupancyGrid()
    for array in (grid.free, grid.occupied, grid.unknown, grid.lidar, grid.depth, grid.clearance()):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 0


def test_a_resolution_that_is_none_is_refused():
    with pytest.raises(ValueError, match="metres a cell"):
        OccupancyGrid(0.0)


def test_what_the_bumper_met_stays_though_the_other_sensors_look_over_it():
    grid = OccupancyGrid()
    grid.integrate_contact(np.array([0.0, 0.0, np.pi / 2]), 0.18)
    ahead = grid.frame.to_cell([0.0, 0.2])
    assert grid.occupied[ahead] and not grid.occupied[grid.frame.to_cell([0.0, -0.2])]
    camera = CameraModel()
    for _ in range(20):
        grid.integrate_depth(np.array([0.0, -2.0, np.pi / 2]), np.full((240, 320), np.nan, np.float32), camera)
    assert grid.occupied[grid.frame.to_cell([0.0, 0.2])]
    again = OccupancyGrid.from_bytes(grid.to_bytes())
    assert np.array_equal(again.occupied, grid.occupied)
