from functools import partial

import networkx as nx
import numpy as np
import pytest

from edge.mapping import frontiers as module
from edge.mapping.frontiers import reachable

frontiers = partial(module.frontiers, robot_radius=0.18)
ROBOT = np.array([1.0, 1.0, 0.0])

OPEN_EAST = """
####################
#...................
#...................
#...................
#...................
#...................
#...................
#...................
####################
"""


def test_the_open_side_is_one_frontier_with_its_middle_as_waypoint(drawn):
    grid = drawn(OPEN_EAST, repeat=2)  # cells of 0.1 m: 4.0 x 1.8 m
    (found,) = frontiers(grid, np.array([1.0, 0.9]))
    assert found.waypoint == pytest.approx([3.95, 0.9], abs=0.11)
    assert (found.cells[:, 0] > 3.9).all()
    assert np.ptp(found.cells[:, 1]) == pytest.approx(1.4 - 0.36, abs=0.25)


def test_a_closed_room_has_none(drawn):
    closed = "\n".join(line[:-1] + "#" for line in OPEN_EAST.split())
    assert frontiers(drawn(closed, repeat=2), np.array([1.0, 0.9])) == []


def pocket(width, height):
    lines = ["#" * 60] + ["#" + "." * 58 + "#"] * 28 + ["#" * 60]
    for row in range(10, 10 + height):
        lines[row] = lines[row][:20] + " " * width + lines[row][20 + width :]
    return "\n".join(lines)


def test_small_pockets_are_ignored_and_large_ones_not(drawn):
    assert frontiers(drawn(pocket(12, 12)), ROBOT) == []  # 1.44 m²
    (found,) = frontiers(drawn(pocket(13, 12)), ROBOT)  # 1.56 m²
    assert found.cells[:, 0].min() > 1.8 and found.cells[:, 0].max() < 3.5
    assert frontiers(drawn(pocket(13, 12)), ROBOT, min_area=1.6) == []


BEHIND_A_WALL = """
##########################
#...........##............
#...........##............
#...........##............
#...........##............
#...........##............
#............{}............
#............{}............
#............{}............
#...........##............
#...........##............
##########################
"""


def test_only_what_the_robot_fits_through_is_reachable(drawn):
    open_door = BEHIND_A_WALL.replace("{}", ".")
    shut = BEHIND_A_WALL.replace(".{}", "##")
    assert len(frontiers(drawn(open_door, repeat=2), ROBOT)) == 1
    assert frontiers(drawn(shut, repeat=2), ROBOT) == []
    assert frontiers(drawn(open_door, repeat=2), ROBOT, robot_radius=0.45) == []


def test_an_opening_narrower_than_the_robot_is_no_frontier(drawn):
    lines = [list(line) for line in OPEN_EAST.split()]
    for line in lines:
        line[-1] = "#"
    lines[4][-1] = "."  # 0.2 m wide
    assert frontiers(drawn("\n".join(map("".join, lines)), repeat=2), np.array([1.0, 0.9])) == []
    lines[3][-1] = lines[5][-1] = lines[6][-1] = "."  # 0.8 m
    (found,) = frontiers(drawn("\n".join(map("".join, lines)), repeat=2), np.array([1.0, 0.9]))
    assert found.waypoint[1] == pytest.approx(0.8, abs=0.11)


def test_two_openings_are_two_frontiers_longest_first(drawn):
    lines = [list("." * 40) for _ in range(40)]
    for i in range(40):
        lines[i][0] = lines[0][i] = lines[i][39] = lines[39][i] = "#"
    for i in range(10, 20):
        lines[i][0] = "."
    for i in range(5, 25):
        lines[0][i] = "."
    west, north = sorted(frontiers(drawn("\n".join(map("".join, lines))), ROBOT), key=lambda f: f.waypoint[0])
    assert len(north.cells) > len(west.cells)
    assert frontiers(drawn("\n".join(map("".join, lines))), ROBOT)[0].waypoint.tolist() == north.waypoint.tolist()
    assert west.waypoint == pytest.approx([0.1, 2.5], abs=0.2) and north.waypoint == pytest.approx([1.5, 3.9], abs=0.2)


def test_an_island_of_explored_ground_is_all_frontier(drawn):
    lines = [" " * 40] * 10 + [" " * 10 + "." * 20 + " " * 10] * 20 + [" " * 40] * 10
    (found,) = frontiers(drawn("\n".join(lines)), np.array([2.0, 2.0]))
    assert len(found.cells) == 4 * 19


def test_what_the_camera_has_not_looked_at_counts_as_unknown(drawn):
    closed = "\n".join(line[:-1] + "#" for line in OPEN_EAST.split())
    grid = drawn(closed, repeat=2)
    explored = np.zeros(grid.frame.shape, bool)
    explored[:, :20] = True
    (found,) = frontiers(grid, np.array([1.0, 0.9]), explored=explored)
    assert found.waypoint[0] == pytest.approx(1.95)


def test_reachable_is_networkx_component():
    from edge.mapping import map_bytes
    from edge.mapping.occupancy import OccupancyGrid

    rng = np.random.default_rng(3)
    layer = np.where(rng.random((40, 40)) < 0.35, 20, -8).astype(np.int8)
    layer[5, 5] = -8
    grid = OccupancyGrid.from_bytes(map_bytes.pack(0.1, np.zeros(2), np.stack([layer, 0 * layer, 0 * layer])))
    graph = nx.grid_2d_graph(40, 40)
    graph.remove_nodes_from(zip(*np.nonzero(layer > 0)))
    wanted = nx.node_connected_component(graph, (5, 5))
    got = reachable(grid, np.array([0.55, 0.55]), 0.05)
    assert set(zip(*(index.tolist() for index in np.nonzero(got)))) == wanted


def test_a_robot_outside_the_map_reaches_nothing(drawn):
    grid = drawn(OPEN_EAST, repeat=2)
    for position in ((-50.0, 0.0), (50.0, 50.0), (0.5, -9.0)):
        assert not reachable(grid, np.array(position), 0.18).any()
        assert frontiers(grid, np.array(position)) == []
