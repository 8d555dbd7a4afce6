import numpy as np
import pytest

from firmware_sim.blueprint import BlueprintConfig, draw


def area(polygon):
    x, y = np.array(polygon).T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize("seed", range(20))
def test_rooms_tile_the_rectangle(seed):
    rooms, walls, doors = draw(np.random.default_rng(seed), BlueprintConfig())
    corners = np.array([corner for room in rooms for corner in room.polygon])
    width, height = corners.max(0)
    assert sum(area(room.polygon) for room in rooms) == pytest.approx(width * height)
    assert min(np.ptp(room.polygon, axis=0).min() for room in rooms) >= 2.1 - 1e-9
    assert len(doors) >= len(rooms) - 1


@pytest.mark.parametrize("seed", range(20))
def test_the_smallest_room_is_the_bathroom_and_has_one_door(seed):
    rooms, _, doors = draw(np.random.default_rng(seed), BlueprintConfig())
    bathroom = next(room for room in rooms if room.name == "bathroom")
    assert area(bathroom.polygon) == pytest.approx(min(area(room.polygon) for room in rooms))
    low, high = np.min(bathroom.polygon, axis=0), np.max(bathroom.polygon, axis=0)
    middles = [np.mean([door.a, door.b], axis=0) for door in doors]
    assert sum(bool((m >= low).all() and (m <= high).all()) for m in middles) == 1


def test_doors_are_gaps_of_their_width_between_walls():
    config = BlueprintConfig()
    _, walls, doors = draw(np.random.default_rng(3), config)
    ends = {wall.a for wall in walls} | {wall.b for wall in walls}
    for door in doors:
        assert np.hypot(*np.subtract(door.a, door.b)) == pytest.approx(config.door_width)
        assert door.a in ends and door.b in ends
