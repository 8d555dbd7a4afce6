import numpy as np
import pytest

from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.polygons import distance_to_segments


def test_clearance_is_the_distance_to_the_walls(empty):
    space = FreeSpace(empty)
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(0.3, 3.7, 100), rng.uniform(0.3, 3.7, 100)])
    row, col = space.frame.to_cell(points)
    expected = distance_to_segments(space.frame.to_world(row, col), empty.wall_segments())
    np.testing.assert_allclose(space.clearance[row, col], expected, atol=0.06)


def test_a_disc_passes_the_doorway_only_when_it_fits(empty):
    space = FreeSpace(empty)
    assert space.reachable_area(0.35)["den"] > 3.0
    assert space.reachable_area(0.55)["den"] == 0.0
    assert space.reachable_area(0.35)["hall"] == pytest.approx((3.9 - 0.7) ** 2, abs=0.6)


def test_furniture_and_closed_doors_are_in_the_way_but_not_what_hangs_or_stands_on_it(plan, boxes, furnished):
    area = FreeSpace(furnished).reachable_area(0.2)
    free = FreeSpace(House.from_dict(plan | {"objects": []}, boxes)).reachable_area(0.2)
    assert area["hall"] < free["hall"] - 0.8
    closed = plan | {"doors": [plan["doors"][0] | {"open": False}]}
    assert FreeSpace(House.from_dict(closed, boxes)).reachable_area(0.2)["den"] == 0.0


def test_behind_a_closed_door_only_what_lies_there_is_reached(plan, boxes):
    space = FreeSpace(House.from_dict(plan | {"objects": [], "doors": [plan["doors"][0] | {"open": False}]}, boxes))
    hall, den = space.reachable(0.2), space.reachable(0.2, np.array([5.5, 2.0]))
    assert hall.any() and den[space.frame.to_cell(np.array([5.5, 2.0]))]
    assert not (hall & den).any()
