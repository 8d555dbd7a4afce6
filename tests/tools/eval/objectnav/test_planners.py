"""The planners differ in what they prefer, and in nothing else."""

import numpy as np
import pytest

from edge.perception.prompts import ENSEMBLE, Target
from tests.edge.missions.conftest import make_robot, make_world
from tools.eval.objectnav.planners import PLANNERS, single_prompts, sub_ensembles
from tools.eval.objectnav.value_map import ValueMap


@pytest.fixture(scope="module")
def robot():
    return make_robot(make_world())


def exploration(robot, planner, seed=0):
    return planner.exploration(robot, Target.of("couch", robot.encoder), seed)


MEANS, VARIANCES, AWAY = np.array([0.5, 0.6, 0.3]), np.array([0.5, 0.01, 0.01]), np.array([3.0, 2.0, 1.0])


@pytest.mark.parametrize(
    ("name", "preferred"), [("I-FBE1", 0), ("I-FBE2", 0), ("mean", 1), ("VLFM", 1), ("closest", 2)]
)
def test_what_each_prefers(robot, name, preferred):
    choose = exploration(robot, PLANNERS[name]).choice._acquisition
    assert int(np.argmax(choose(MEANS, VARIANCES, AWAY))) == preferred


def test_the_random_one_depends_on_its_seed_alone(robot):
    random = PLANNERS["random"]
    drawn = [exploration(robot, random, seed).choice._acquisition(MEANS, VARIANCES, AWAY) for seed in (1, 1, 2)]
    assert (drawn[0] == drawn[1]).all() and (drawn[0] != drawn[2]).any()


def test_vlfm_has_one_prompt_and_its_own_map(robot):
    found = exploration(robot, PLANNERS["VLFM"])
    assert isinstance(found.relevance, ValueMap) and found.prompts.shape[0] == 1
    assert exploration(robot, PLANNERS["I-FBE2"]).prompts.shape[0] == len(ENSEMBLE)


def test_sub_ensembles_are_different_ones_and_the_same_for_a_seed():
    drawn = sub_ensembles(3)
    assert len(drawn) == len(ENSEMBLE) == len({planner.prompts for planner in drawn.values()})
    assert drawn == sub_ensembles(3) and all(len(planner.prompts) == 4 for planner in drawn.values())
    assert [planner.prompts for planner in single_prompts().values()] == [(i,) for i in range(len(ENSEMBLE))]
