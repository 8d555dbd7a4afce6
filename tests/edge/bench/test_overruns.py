"""What is over a board's budget, and named so."""

import pytest

from edge.bench.overruns import BOARD, HOST, overruns
from edge.bench.report import STEP, Process, Report, Stage
from edge.budget import BUDGETS

ZERO = BUDGETS["pi-zero-2w"]


def report(board=150.0, host=120.0, ram=1.2, disk=1.6, step=60.0, mean=30.0):
    processes = {BOARD: Process(board, 0, 0, 0, 0), HOST: Process(host, 0, 0, 0, 0)}
    stages = {
        f"{BOARD}: {STEP}": Stage(20.0, step, 200.0, mean, 0.1, 9),
        "planning: slow": Stage(1e3, 1e3, 1e3, 1e3, 0.0, 9),
    }
    sizes = {"store: memory, RAM": ram, "store: memory, disk": disk, f"{BOARD}: memory of the home": 99.0}
    return Report("x", "m", 1, stages, processes, sizes)


def test_within_it_nothing_is_said():
    assert overruns(report(), ZERO) == []


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"board": 170.1}, "mission: peak PSS is 170.1 MB, over 170"),
        ({"host": 131.0}, "text on the host: peak PSS is 131.0 MB, over 130"),
        ({"ram": 1.6}, "RAM is 1.6 MB, over 1.5"),
        ({"disk": 2.6}, "disk is 2.6 MB, over 2.5"),
        ({"mean": 51.0}, "of a core at 10 Hz is 51.0 %, over 50"),
        ({"step": 101.0}, "whole step: p95 is 101.0 ms, over 100"),
    ],
)
def test_what_is_over_it_is_named(changed, words):
    (problem,) = overruns(report(**changed), ZERO)
    assert words in problem


def test_a_larger_board_has_more():
    assert len(overruns(report(board=200.0, host=150.0), ZERO)) == 2
    assert overruns(report(board=200.0, host=150.0), BUDGETS["qcs605"]) == []


def test_what_was_not_measured_is_not_judged():
    assert overruns(Report("x", "m"), ZERO) == []
