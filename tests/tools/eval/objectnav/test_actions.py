"""Discrete actions on the simulated base."""

import numpy as np
import pytest

from edge.pose import between
from firmware_sim.house import House
from firmware_sim.world import World
from tests.edge.missions.conftest import PLAN
from tools.eval.objectnav.actions import FORWARD, TURN, Actor


def moved(action, start, times=1):
    world = World(House.from_dict(PLAN), 0, start=start)
    actor, heard = Actor(world), []
    world.step(None)
    before = world.truth
    for _ in range(times):
        last = actor.act(action, heard.append)
    return between(before, world.truth), last, heard, world


@pytest.mark.parametrize(("action", "turn"), [("left", TURN), ("right", -TURN)])
def test_a_turn_is_thirty_degrees_on_the_spot(action, turn):
    (x, y, theta), last, heard, world = moved(action, (2.0, 2.0, 0.0))
    assert theta == pytest.approx(turn, abs=np.radians(3)) and np.hypot(x, y) < 0.02
    assert abs(last.twist).max() < 0.05 and last.frame is not None and all(o.frame is None for o in heard)


def test_forward_is_a_quarter_of_a_metre():
    (x, y, theta), *_ = moved("forward", (2.0, 2.0, 0.0), times=4)
    assert x == pytest.approx(4 * FORWARD, abs=0.06) and abs(y) < 0.1


def test_a_wall_ends_it():
    (x, *_), last, heard, world = moved("forward", (3.0, 3.0, 0.0), times=4)
    assert 0.6 < x < 0.85 and world.contacts >= 1 and any(o.bumper for o in heard)


def test_stop_does_nothing():
    motion, last, heard, _ = moved("stop", (2.0, 2.0, 0.0))
    assert motion == pytest.approx([0, 0, 0], abs=1e-3) and not heard and last.frame is not None
