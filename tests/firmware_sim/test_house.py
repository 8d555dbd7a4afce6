import copy
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from firmware_sim.house import House
from firmware_sim.lidar import Lidar, LidarConfig
from firmware_sim.placement import HouseError


def with_objects(plan, *entries):
    return plan | {"objects": list(entries)}


CUBE = {"id": "cube-1", "model": "cube", "position": [2.0, 2.5]}


def test_loads_a_file_and_gives_it_back(plan, boxes, tmp_path):
    data = with_objects(plan, CUBE | {"yaw": 1.0})
    path = tmp_path / "boxes.json"
    path.write_text(json.dumps(data))
    house = House.load(path, boxes)
    assert house.objects["cube-1"].yaw == 1.0
    assert House.from_dict(house.to_dict(), boxes).to_dict() == house.to_dict()


def test_rooms_answer_where_a_point_lies(empty):
    assert empty.room_at(1, 1).name == "hall"
    assert empty.room_at(5, 1).name == "den"
    assert empty.room_at(8, 1) is None
    np.testing.assert_allclose(empty.bounds, [[0, 0], [7, 4]])


def test_on_takes_its_height_from_the_top_below(furnished):
    assert furnished.objects["lamp-1"].elevation == 0.7
    assert furnished.objects["lamp-1"].height_range == (0.7, 1.2)


def test_on_may_name_a_thing_that_comes_later_in_the_file(plan, boxes):
    lamp = {"id": "lamp-1", "model": "lamp", "position": [2.0, 2.5], "on": "table-1"}
    table = {"id": "table-1", "model": "table", "position": [2.0, 2.5]}
    house = House.from_dict(with_objects(plan, lamp, table), boxes)
    assert list(house.objects) == ["lamp-1", "table-1"]
    assert house.objects["lamp-1"].elevation == 0.7


@pytest.mark.parametrize(
    "entry, sentence",
    [
        (CUBE | {"position": [0.1, 2.0]}, "object 'cube-1' at (0.10, 2.00) is inside a wall"),
        (CUBE | {"position": [9.0, 2.0]}, "outside every room"),
        (CUBE | {"model": "sphere"}, "unknown model 'sphere'"),
        (CUBE | {"on": "ghost"}, "stands on 'ghost', which does not exist"),
        (CUBE | {"on": "cube-1"}, "on itself"),
        (CUBE | {"elevation": 2.3}, "through the ceiling"),
        (CUBE | {"position": [1.2, 2.0]}, "the start (1.00, 2.00) is blocked by object 'cube-1'"),
        (CUBE | {"colour": "red"}, "colour"),
        (CUBE | {"position": [1.0]}, r"$.objects[0].position"),
    ],
)
def test_one_sentence_names_the_fault_of_an_object(plan, boxes, entry, sentence):
    with pytest.raises(HouseError) as caught:
        House.from_dict(with_objects(plan, entry), boxes)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "other, sentence",
    [
        ({"id": "lamp-1", "model": "lamp", "position": [2.2, 2.5]}, "overlaps"),
        ({"id": "lamp-1", "model": "lamp", "position": [2.0, 2.5], "on": "cube-1"}, "no top to stand on"),
        ({"id": "cube-1", "model": "lamp", "position": [3.0, 1.0]}, "two objects are called 'cube-1'"),
    ],
)
def test_one_sentence_names_the_fault_of_a_pair(plan, boxes, other, sentence):
    with pytest.raises(HouseError, match=sentence):
        House.from_dict(with_objects(plan, CUBE, other), boxes)


def test_a_thing_must_be_above_what_it_stands_on(plan, boxes):
    table = {"id": "table-1", "model": "table", "position": [2.0, 1.0]}
    lamp = {"id": "lamp-1", "model": "lamp", "position": [2.0, 2.0], "on": "table-1"}
    with pytest.raises(HouseError, match="not above 'table-1'"):
        House.from_dict(with_objects(plan, table, lamp), boxes)


def test_things_may_share_a_place_at_different_heights(plan, boxes):
    shelf = {"id": "shelf-1", "model": "shelf", "position": [2.0, 3.78], "elevation": 1.4}
    table = {"id": "table-1", "model": "table", "position": [2.0, 3.6]}
    House.from_dict(with_objects(plan, shelf, table), boxes)


def test_start_in_a_wall_or_outside_is_refused(plan, boxes):
    with pytest.raises(HouseError, match="blocked by a wall"):
        House.from_dict(plan | {"start": [0.1, 2.0, 0.0]}, boxes)
    with pytest.raises(HouseError, match="outside every room"):
        House.from_dict(plan | {"start": [-3.0, 2.0, 0.0]}, boxes)


def leaves(value, path=()):
    """Paths of all numbers, strings and truth values in nested dicts and lists."""
    if isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(part, (*path, key))
    else:
        yield path


junk = st.none() | st.floats() | st.integers() | st.text(max_size=3) | st.lists(st.floats(), max_size=3) | st.booleans()


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.data())
def test_junk_anywhere_in_a_file_is_refused_with_one_sentence_or_harmless(furnished, boxes, data):
    content = copy.deepcopy(furnished.to_dict())
    *path, last = data.draw(st.sampled_from(list(leaves(content))))
    part = content
    for key in path:
        part = part[key]
    part[last] = data.draw(junk)
    try:
        House.from_dict(content, boxes)
    except HouseError as error:
        assert str(error) and "\n" not in str(error)


def test_missing_file_names_the_homes_at_hand(tmp_path):
    with pytest.raises(HouseError, match="cannot read"):
        House.load(tmp_path / "nowhere.json", {})


def test_broken_json_names_the_file(tmp_path):
    path = tmp_path / "broken.json"
    path.write_text('{"name": ')
    with pytest.raises(HouseError, match="broken.json"):
        House.load(path, {})


def test_moving_takes_along_what_stands_on_it(furnished):
    furnished.move_object("table-1", 2.0, 1.0, yaw=np.pi / 2)
    lamp = furnished.objects["lamp-1"]
    np.testing.assert_allclose([lamp.x, lamp.y, lamp.yaw, lamp.elevation], [2.0, 1.3, np.pi / 2, 0.7], atol=1e-12)


def test_every_change_is_noticed(furnished):
    seen = [furnished.revision]
    furnished.move_object("lamp-1", 3.0, 1.0)
    seen.append(furnished.revision)
    furnished.add_object("cube-2", "cube", 2.0, 1.0)
    seen.append(furnished.revision)
    furnished.remove_object("cube-2")
    seen.append(furnished.revision)
    assert len(set(seen)) == 4
    assert furnished.objects["lamp-1"].elevation == 0.0


def test_a_closed_door_is_a_wall_until_it_is_opened(empty):
    pose, revision = np.array([3.0, 2.0, 0.0]), empty.revision
    lidar = Lidar(empty, LidarConfig(), None)
    assert lidar.scan(pose)[180] == pytest.approx(3.95)  # straight ahead, through the doorway, to the den's far wall
    empty.set_door(0, open=False)
    assert lidar.scan(pose)[180] == pytest.approx(0.95) and empty.revision > revision
    empty.set_door(0, open=True)
    assert lidar.scan(pose)[180] == pytest.approx(3.95)
    with pytest.raises(HouseError, match="1 doors"):
        empty.set_door(3, open=False)


def test_a_refused_move_changes_nothing(furnished):
    before, revision = furnished.to_dict(), furnished.revision
    with pytest.raises(HouseError, match="inside a wall"):
        furnished.move_object("table-1", 2.0, 3.8)
    with pytest.raises(HouseError, match="cannot stand on 'lamp-1'"):
        furnished.move_object("table-1", 2.0, 2.0, on="lamp-1")
    with pytest.raises(HouseError, match="no object 'ghost'"):
        furnished.move_object("ghost", 2.0, 2.0)
    with pytest.raises(HouseError, match="stands on 'table-1'; remove it first"):
        furnished.remove_object("table-1")
    assert furnished.to_dict() == before and furnished.revision == revision
