"""Where stopping counts, against NetworkX's shortest paths and plain geometry."""

import networkx as nx
import numpy as np
import pytest

from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.placement import ROBOT_RADIUS
from tests.edge.missions.conftest import PLAN
from tools.eval.objectnav.goal_region import CLEARANCE, GoalRegion

HOUSE = House.from_dict(PLAN)


def test_distance_is_to_the_outline_in_line_of_sight():
    region = GoalRegion(HOUSE, "dustbin")
    outline = HOUSE.objects["dustbin-1"].footprint
    left = outline[:, 0].min()
    assert region.distance([left - 0.5, 0.4]) == pytest.approx(0.5, abs=0.02)
    assert region.distance([left - 3.5, 0.4]) == np.inf  # far away, and beyond the wall


def test_whose_place_it_is():
    region, outline = GoalRegion(HOUSE, "dustbin"), HOUSE.objects["dustbin-1"].footprint
    assert region.shows(outline.mean(axis=0), 0.0)
    assert region.shows([outline[:, 0].min() - 0.4, 0.4], 0.5) and not region.shows(
        [outline[:, 0].min() - 0.6, 0.4], 0.5
    )


def test_what_a_door_jamb_leaves_to_see_counts(monkeypatch):
    region = GoalRegion(HOUSE, "dustbin")
    place = np.array([HOUSE.objects["dustbin-1"].footprint[:, 0].min() - 0.5, 0.4])
    jamb = region._walls.copy()
    row, col = (int(i) for i in region._space.frame.to_cell(place + [0.25, 0.0]))
    jamb[row, col] = True
    monkeypatch.setattr(region, "_walls", jamb)
    assert 0.5 < region.distance(place) < 0.7


def test_a_wall_between_hides_it():
    region = GoalRegion(HOUSE, "armchair")
    right = HOUSE.objects["armchair-1"].footprint[:, 0].max()
    assert right < 4.0 and region.distance([4.3, 0.7]) == np.inf
    assert region.distance([right - 1.5, 0.7]) < np.inf


def test_floor_that_is_only_connected_across_a_corner_is_not_reached(monkeypatch):
    """A disc cannot pass between two blocked cells that touch at a corner, and no path is planned there."""
    region = GoalRegion(HOUSE, "teddy bear")
    clearance = np.zeros_like(region._space.clearance)
    row, col = (int(i) for i in region._space.frame.to_cell(np.array(HOUSE.start[:2])))
    clearance[row, col] = clearance[row + 1, col + 1] = 1.0
    monkeypatch.setattr(region._space, "clearance", clearance)
    monkeypatch.setattr(region, "_away", lambda thing, places: np.where(places[:, 1] > places[:, 1].min(), 0.0, np.inf))
    assert region.shortest_path(HOUSE.start) == np.inf


def test_nothing_is_near_what_the_home_does_not_have():
    region = GoalRegion(HOUSE, "submarine")
    assert region.distance([2.0, 2.0]) == np.inf and region.shortest_path(HOUSE.start) == np.inf


@pytest.mark.parametrize("noun", ["teddy bear", "dustbin", "armchair"])
def test_the_shortest_way_is_as_short_as_dijkstras_and_no_shorter_than_the_crow_flies(noun):
    region, space = GoalRegion(HOUSE, noun), FreeSpace(HOUSE)
    free = space.clearance >= ROBOT_RADIUS
    graph = nx.grid_2d_graph(*free.shape)
    graph.add_edges_from(
        ((r, c), (r + 1, c + d), {"weight": 2**0.5})
        for r in range(free.shape[0] - 1)
        for c in range(1, free.shape[1] - 1)
        for d in (-1, 1)
        if free[r, c + d] and free[r + 1, c]
    )
    graph.remove_nodes_from([(int(r), int(c)) for r, c in np.argwhere(~free)])
    start = tuple(int(i) for i in space.frame.to_cell(np.array(HOUSE.start[:2])))
    lengths = nx.single_source_dijkstra_path_length(graph, start)
    reached = {
        cell: length for cell, length in lengths.items() if region.distance(space.frame.to_world(*cell)) <= CLEARANCE
    }
    best = min(reached.values()) * space.frame.resolution
    straight = min(np.hypot(*(space.frame.to_world(*cell) - HOUSE.start[:2])) for cell in reached)
    found = region.shortest_path(HOUSE.start)
    assert straight - 0.1 <= found <= best * 1.03 + 0.05
