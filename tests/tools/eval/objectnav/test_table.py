"""What the tables say of episodes that are made up, so that it can be counted by hand."""

from dataclasses import replace

import numpy as np
import pytest

from tools.eval.objectnav.episode import Episode
from tools.eval.objectnav.table import ENSEMBLES, SINGLE, margin, rows, show, show_spread, spread

RIGHT = Episode(
    home="a", planner="I-FBE2", noun="couch", ending="found", success=True, spl=0.5, cause="", claimed="Couch",
    actions=40, length=8.0, shortest=4.0, distance=0.8, bumps=0, seen=True, confidence=0.7,
)  # fmt: skip
WRONG = replace(RIGHT, success=False, spl=0.0, cause="false positive", distance=np.inf)


def asked(planner: str, right: str) -> list[Episode]:
    """An episode in home 0, 1, …; ``right`` has a 1 for each success."""
    return [replace(RIGHT if it == "1" else WRONG, home=str(home), planner=planner) for home, it in enumerate(right)]


def test_a_row_counts_a_planner():
    (row,) = rows(asked("I-FBE2", "1100"))
    assert (row.planner, row.episodes, row.causes) == ("I-FBE2", 4, {"false positive": 2})
    assert row.success.mean == 0.5 and row.spl.mean == 0.25 and row.actions.mean == 40


def test_margins_are_of_the_same_questions():
    ours, theirs = asked("I-FBE2", "1101"), asked("closest", "100")
    success, spl = margin(ours + theirs, "I-FBE2", "closest")
    assert success.mean == pytest.approx(1 / 3) and spl.mean == pytest.approx(0.5 / 3)
    assert (success.low, success.high) == (0.0, 1.0)


def test_each_single_prompt_is_held_against_the_ensemble():
    episodes = asked("VLFM, prompt 1", "1000") + asked("VLFM, prompt 2", "0000") + asked("I-FBE2", "1111")
    text = show(episodes)
    assert "I-FBE2 has +0.750 [+0.250, +1.000] more SR" in text and "than VLFM, prompt 2" in text


def test_the_spread_is_over_planners_of_a_kind():
    singles = asked(f"{SINGLE} 1", "1111") + asked(f"{SINGLE} 2", "0000")
    ensembles = asked(f"{ENSEMBLES} 12", "1100") + asked(f"{ENSEMBLES} 13", "0011")
    rates, more = spread(singles + ensembles)
    assert list(rates[SINGLE]) == [1.0, 0.0] and list(rates[ENSEMBLES]) == [0.5, 0.5]
    assert more.mean == 0.5  # standard deviations of 0.5 and 0
    assert more.low == 0.0  # all four homes drawn from one pair: the ensembles are as far apart
    assert "by +0.500 [" in show_spread(singles + ensembles)
