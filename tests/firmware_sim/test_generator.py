import json

import numpy as np
import pytest

from firmware_sim.free_space import FreeSpace
from firmware_sim.furniture import Furniture
from firmware_sim.generator import generate
from firmware_sim.house import House

SEEDS = (0, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89, 144, 233, 377, 610, 987)


@pytest.fixture(scope="module")
def furniture():
    return Furniture.load()


@pytest.fixture(scope="module", params=SEEDS)
def home(request, furniture):
    return generate(request.param, furniture)


def test_is_a_furnished_home(home):
    names = [room.name for room in home.rooms]
    assert {"living room", "kitchen", "bedroom", "bathroom"} <= set(names)
    assert len(names) == len(set(names)) >= 5
    assert len(home.objects) >= 25
    assert len({thing.model.name for thing in home.objects.values()}) >= 20
    width, height = home.bounds[1] - home.bounds[0]
    assert width <= 11 and height <= 9


def test_the_robot_reaches_every_room(home):
    area = FreeSpace(home).reachable_area(0.18 + 0.10)
    assert min(area.values()) > 1.0, area


def test_every_room_has_its_things(home):
    for room in home.rooms:
        inside = [thing for thing in home.objects.values() if home.room_at(thing.x, thing.y) is room]
        assert len(inside) >= 2, room.name


def test_survives_a_file(home, furniture):
    again = House.from_dict(json.loads(json.dumps(home.to_dict())), furniture)
    assert again.to_dict() == home.to_dict()


def test_the_same_seed_gives_the_same_home(furniture):
    first = generate(7, furniture).to_dict()
    assert first == generate(7, furniture).to_dict()
    assert first["rooms"] != generate(9, furniture).to_dict()["rooms"]


def test_no_thing_stands_in_a_doorway(home):
    for door in home.doors:
        middle = np.mean([door.a, door.b], axis=0)
        gaps = [np.hypot(*(thing.footprint - middle).T).min() for thing in home.objects.values() if thing.on is None]
        assert min(gaps) > 0.45
