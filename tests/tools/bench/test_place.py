"""One awakening and one push in a small furnished home, and what the command says."""

import json
import sys

import pytest

from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from tests.edge.missions.conftest import PLAN
from tools.bench import place
from tools.bench.survey import survey


@pytest.fixture(scope="module")
def home():
    house = House.from_dict(PLAN)
    return house, survey(house), FreeSpace(house)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_it_wakes_up_where_it_is(home, seed):
    woken = place.wake(*home, seed)
    assert woken.found and woken.right and woken.seconds > 0


def test_in_the_map_of_another_home_it_is_not_right(home, monkeypatch):
    house, _, space = home
    other = House.from_dict(PLAN | {"walls": PLAN["walls"][:4], "doors": [], "objects": []})
    woken = place.wake(house, survey(other), space, 0)
    assert not woken.right


def test_pushed_it_arrives_and_knows_where_it_is(home):
    house, grid, space = home
    arrived, error = place.pushed(house, grid.to_bytes(), space, 1)
    assert arrived and error < 0.05


def test_the_table(tmp_path, monkeypatch, capsys):
    (tmp_path / "home.json").write_text(json.dumps(PLAN))
    monkeypatch.setattr(sys, "argv", ["place", "--homes", str(tmp_path / "home.json"), "--runs", "1"])
    place.main()
    heads, line = capsys.readouterr().out.splitlines()
    assert heads.split()[:3] == ["woken", "found", "wrong"] and line.startswith("two rooms") and line.endswith(" m")


@pytest.mark.parametrize("arguments", [["--homes", "nowhere"], ["--runs", "0"]])
def test_a_mistake_is_told_in_a_sentence(monkeypatch, capsys, arguments):
    monkeypatch.setattr(sys, "argv", ["place", *arguments])
    with pytest.raises(SystemExit) as ended:
        place.main()
    assert ended.value.code == 2 and "Traceback" not in capsys.readouterr().err
