"""The homes that come along, furnished from the real pack."""

from collections import Counter

import numpy as np
import pytest

from firmware_sim.free_space import FreeSpace
from firmware_sim.furniture import Furniture
from firmware_sim.house import House

HANDMADE = ("apartment", "cottage", "bungalow")


@pytest.fixture(scope="module")
def furniture():
    return Furniture.load()


@pytest.fixture(scope="module", params=HANDMADE)
def home(request, furniture):
    return House.load(request.param, furniture)


def test_is_a_furnished_home_of_some_rooms(home):
    assert len(home.rooms) >= 4
    assert len(home.objects) >= 25
    width, height = home.bounds[1] - home.bounds[0]
    assert width <= 11 and height <= 9


def test_has_many_things_that_a_name_tells_apart(home):
    names = Counter(thing.model.name for thing in home.objects.values())
    assert sum(count <= 2 for count in names.values()) >= 15


def test_the_robot_reaches_every_room_with_room_to_spare(home):
    area = FreeSpace(home).reachable_area(0.18 + 0.15)
    assert min(area.values()) > 1.0, area


def test_most_things_stand_where_a_camera_at_088_m_sees_them(home):
    seen = [0.12 < thing.height_range[1] and thing.elevation < 1.6 for thing in home.objects.values()]
    assert np.mean(seen) > 0.9


def test_things_stand_near_floor_that_the_robot_reaches(home):
    space = FreeSpace(home)
    rows, cols = np.nonzero(space.reachable(0.18 + 0.05))
    floor = space.frame.to_world(rows, cols)
    for thing in home.objects.values():
        assert np.hypot(*(floor - (thing.x, thing.y)).T).min() < 2.5, thing.id
