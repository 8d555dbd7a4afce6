import os

import pytest

from tools.eval.child import in_child

state = {"count": 0}


def count(step):
    state["count"] += step
    return state["count"], os.getpid()


def test_a_child_starts_from_this_state_and_leaves_it_alone():
    state["count"] = 5
    for _ in range(2):
        value, process = in_child(count, 2)
        assert value == 7 and process != os.getpid()
    assert state["count"] == 5


def test_errors_come_back():
    with pytest.raises(ZeroDivisionError):
        in_child(lambda: 1 / 0)


def test_a_child_that_dies_is_reported():
    with pytest.raises(RuntimeError, match="exit code 3"):
        in_child(lambda: os._exit(3))
