"""The draw of who crosses where, and one small run of the whole."""

import json
import sys

import numpy as np
import pytest

from firmware_sim.base import Contact
from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.placement import ROBOT_RADIUS
from tools.bench import crossing
from tools.bench.crossing import Driven, NoCrossing, meet, row
from tools.bench.survey import survey

CORNERS = [[0, 0], [7, 0], [7, 6], [0, 6]]
HALL = {
    "name": "hall",
    "rooms": [{"name": "hall", "category": "Living room", "polygon": CORNERS}],
    "walls": [{"a": a, "b": b} for a, b in zip(CORNERS, CORNERS[1:] + CORNERS[:1])],
    "doors": [],
    "objects": [{"id": "couch-1", "model": "couch", "position": [3.5, 5.4]}],
    "start": [1.0, 1.0, 0.0],
}
TIMES = np.arange(0, 12, 0.1)
WAY = np.stack([TIMES, 0.8 + 0.45 * TIMES, np.full(len(TIMES), 2.5)], axis=1)  # along the hall


@pytest.fixture(scope="module")
def hall():
    return House.from_dict(HALL)


@pytest.fixture(scope="module")
def grid(hall):
    return survey(hall)


@pytest.mark.parametrize("seed", range(20))
def test_who_crosses_would_be_met_has_room_and_blocks_nobody(hall, seed):
    space = FreeSpace(hall)
    person = crossing.crossing(WAY, space, np.random.default_rng(seed))
    gaps = np.hypot(*(person.position(TIMES) - WAY[:, 1:]).T)
    assert gaps.min() < person.radius + ROBOT_RADIUS and gaps[0] > 0.75
    assert 0.5 <= person.speed <= 1.2
    a, b = person.waypoints
    assert np.abs((a - WAY[:, 1:])[:, 1]).min() > 0.75 and np.abs((b - WAY[:, 1:])[:, 1]).min() > 0.75
    along = np.abs(b - a) / np.hypot(*(b - a))
    assert along[0] <= np.cos(np.radians(60)) + 1e-9
    for place in np.linspace(a, b, 50):
        assert space.clearance[space.frame.to_cell(place)] >= 0.25


def test_in_a_passage_nobody_crosses(hall):
    narrow = dict(HALL, walls=HALL["walls"] + [{"a": [0, y], "b": [7, y]} for y in (1.6, 3.4)])
    with pytest.raises(NoCrossing, match="cross"):
        crossing.crossing(WAY, FreeSpace(House.from_dict(narrow)), np.random.default_rng(0))


def test_both_drives_are_the_same_but_for_the_person_and_repeat(hall, grid):
    alone, met = meet(hall, grid.to_bytes(), FreeSpace(hall), 3)
    assert alone.arrived and met.arrived and not alone.contacts and not met.contacts
    assert alone.closest == np.inf and 0 < met.closest < 2 and met.error < 0.1
    again = meet(hall, grid.to_bytes(), FreeSpace(hall), 3)[1]
    np.testing.assert_array_equal(met.way, again.way)


def test_a_row_counts_what_was_met_and_whether_the_robot_moved():
    way = np.array([[0.1, 0, 0], [8.0, 0, 0]])
    alone = Driven(True, way, [], np.inf, 0.01)
    contacts = [Contact(1, True, 0.3), Contact(2, True, 0.0), Contact(3, False, 0.1)]
    bad = Driven(True, way + [2, 0, 0], contacts, -0.01, 0.01)
    lost = Driven(False, way, [], 0.2, 0.03)
    assert row("hall", [(alone, bad), (alone, lost)]).split() == "hall 2 2 1 2 1 2.0 s -0.01 m 0.010 0.022 m".split()


def test_the_command_prints_a_table_and_tells_what_is_wrong(grid, tmp_path, monkeypatch, capsys):
    home = tmp_path / "hall.json"
    home.write_text(json.dumps(HALL))
    monkeypatch.setattr(crossing, "survey", lambda house: grid)
    monkeypatch.setattr(sys, "argv", ["crossing", "--homes", str(home), "--runs", "1", "--seed", "5"])
    crossing.main()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split()[:3] == ["home", "runs", "person"] and lines[1].startswith("hall") and len(lines) == 3
    for arguments, words in ((["--homes", "castle"], "castle"), (["--runs", "0"], "at least 1")):
        monkeypatch.setattr(sys, "argv", ["crossing", *arguments])
        with pytest.raises(SystemExit) as stop:
            crossing.main()
        assert stop.value.code == 2 and words in capsys.readouterr().err
