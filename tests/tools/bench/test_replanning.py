"""Timing of ObjectNav's steps, with true eyes; the figures themselves are a benchmark's."""

import sys

import pytest

from edge.bench.stopwatch import Stopwatch
from tools.bench import replanning
from tools.bench.replanning import STAGES, show, steps_of
from tools.eval.objectnav.episode import Run
from tools.eval.objectnav.planners import PLANNERS
from tools.eval.oracle import OracleEncoder


def test_each_stage_of_a_step_is_timed_and_no_more_than_the_whole(home):
    run, watch = Run(home, "teddy bear", PLANNERS["I-FBE2"], None, 0), Stopwatch()
    watch.watch(run.robot.encoder, "encode_image", STAGES[1])
    steps = steps_of(run, watch)
    assert run.agent.ending == "found" and steps
    for step in steps:
        assert 0 < sum(step.get(stage, 0.0) for stage in STAGES) <= step["step"]
    assert isinstance(run.robot.encoder, OracleEncoder) and len(show(steps).splitlines()) == 2 + len(STAGES)


def test_a_wrong_home_is_told(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["replanning", "--homes", "castle"])
    with pytest.raises(SystemExit) as stop:
        replanning.main()
    assert stop.value.code == 2 and "castle" in capsys.readouterr().err
