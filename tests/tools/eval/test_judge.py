"""The metric against the paper's own table, and the judge in a house where the truth is plain."""

import numpy as np
import pytest

from firmware_sim.house import House
from firmware_sim.world import World, WorldConfig
from tests.edge.missions.conftest import PLAN
from tools.eval.judge import judge, sae


def test_sae_of_a_perfect_run_is_one_and_of_a_right_angle_1_over_e():
    assert sae([True], [0.0]) == 1.0
    assert sae([True], [np.pi / 2]) == pytest.approx(np.exp(-1))
    assert sae([True, False], [0.0, 0.0]) == 0.5
    assert sae([True], [float("nan")]) == 1.0  # it says rightly that the thing is not here


def world_at(pose):
    return World(House.from_dict(PLAN), 0, WorldConfig(camera=False), start=pose)


def test_an_object_straight_ahead_is_in_view():
    verdict = judge(world_at((5.4, 2.4, np.pi / 4)), "Teddy bear")
    assert verdict.in_view and verdict.object_id == "teddy-1" and verdict.angular_error < 0.02


def test_an_object_behind_the_robot_is_not():
    verdict = judge(world_at((5.4, 2.4, -3 * np.pi / 4)), "teddy bear")
    assert not verdict.in_view and verdict.angular_error > 3


def test_an_object_behind_a_wall_is_not():
    assert not judge(world_at((3.0, 3.0, 0.1)), "teddy bear").in_view


def test_a_noun_that_is_nowhere_has_no_instance():
    verdict = judge(world_at((2.0, 2.0, 0.0)), "submarine")
    assert not verdict.in_view and verdict.object_id == "" and np.isnan(verdict.angular_error)
