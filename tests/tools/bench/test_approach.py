"""What counts as overshoot, on made-up courses, and one small run."""

import json
import sys

import numpy as np
import pytest

from tests.edge.missions.conftest import PLAN
from tools.bench import approach
from tools.bench.approach import Course

DEGREE = np.radians(1)


def course(bearings, depths=(2.0, 1.5), centred=True):
    return Course(centred, np.full(len(bearings), 0.05), DEGREE * np.array(bearings, float), np.array(depths, float))


@pytest.mark.parametrize("side", [1, -1])
def test_overshoot_in_heading_is_what_lies_on_the_other_side_after_the_middle(side):
    bearings = side * np.array([20, 8, 1.5, -3, -1, 0.5])
    assert course(bearings).heading_overshoot(2 * DEGREE) == pytest.approx(3 * DEGREE)
    assert course(side * np.array([20, 8, 1.5, 1, 0.5, 4])).heading_overshoot(2 * DEGREE) == 0.0
    assert np.isnan(course(side * np.array([20, 8, 5])).heading_overshoot(2 * DEGREE))
    lost = course(side * np.array([20, np.nan, 1, np.nan, -2.5]))
    assert lost.heading_overshoot(2 * DEGREE) == pytest.approx(2.5 * DEGREE)


def test_overshoot_in_distance_is_what_comes_nearer_than_the_standoff():
    assert course([20, 0], (2.4, 1.42, np.nan, 1.5)).distance_overshoot(1.5) == pytest.approx(0.08)
    assert course([20, 0], (2.4, 1.6)).distance_overshoot(1.5) == 0.0
    assert course([20, 0], (0.9, 0.8, 0.95)).distance_overshoot(1.5) == pytest.approx(0.1)


def test_a_small_run_prints_the_figures_and_a_wrong_home_is_told(tmp_path, monkeypatch, capsys):
    home = tmp_path / "two-rooms.json"
    home.write_text(json.dumps(PLAN))
    command = ["approach", "--homes", str(home), "--objects", "1", "--encoder", "oracle", "--seed", "2"]
    monkeypatch.setattr(sys, "argv", command)
    approach.main()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "1 objects, 1 found at the first look, 1 centred" and "Hz" in lines[1] and len(lines) == 5
    for arguments, words in ((["--homes", "castle"], "castle"), (["--objects", "0"], "at least 1")):
        monkeypatch.setattr(sys, "argv", ["approach", *arguments])
        with pytest.raises(SystemExit) as stop:
            approach.main()
        assert stop.value.code == 2 and words in capsys.readouterr().err
