"""An agent's decisions, one by one."""

import numpy as np
import pytest

from edge.mapping.object_goal import ObjectGoal, Surface
from edge.missions.exploration import Likeness
from tools.eval.objectnav.agent import AgentConfig
from tools.eval.objectnav.candidates import Candidate
from tools.eval.objectnav.episode import Run
from tools.eval.objectnav.planners import PLANNERS


def test_only_what_is_near_is_looked_at_closely(home, monkeypatch):
    run = Run(home, "teddy bear", PLANNERS["closest"], None, 0)
    exploration, robot = run.agent.exploration, run.robot
    look_closely, away = exploration.look_closely, []

    def measured():
        place = exploration.goal.nearest(robot.pose)
        away.append(float(((place - robot.pose[:2]) ** 2).sum() ** 0.5))
        return look_closely()

    monkeypatch.setattr(exploration, "look_closely", measured)
    noticed = 0.0
    while not run.done:
        run.step()
        if exploration.goal is not None and not noticed:
            noticed = float(((exploration.goal.nearest(robot.pose) - robot.pose[:2]) ** 2).sum() ** 0.5)
    assert away and max(away) < AgentConfig.near < noticed


@pytest.fixture
def begun(home):
    """An agent that has looked around, in search of what is not in view from there."""
    run = Run(home, "teddy bear", PLANNERS["closest"], None, 0)
    while run.agent.actions < 12:
        run.step()
    return run


def goal_ahead(run, ahead):
    """An object on the robot's axis, that it saw from where it is."""
    x, y, heading = run.robot.pose
    place = np.array([x, y]) + ahead * np.array([np.cos(heading), np.sin(heading)])
    return ObjectGoal(Surface(place[None], False, origin=np.array([x, y])))


def test_of_the_guesses_the_best_that_there_is_a_way_to_counts(begun):
    nowhere, here = goal_ahead(begun, 60.0), goal_ahead(begun, 1.2)
    begun.agent._story = begun.agent._settle_for([nowhere, here])
    while not begun.done:
        begun.step()
    assert begun.agent.ending == "guessed" and begun.agent.aim is here
    assert np.hypot(*(here.centroid - begun.robot.pose[:2])) < 1.2


def test_without_a_guess_it_says_so(begun):
    begun.agent._story = begun.agent._settle_for([])
    begun.step()
    assert begun.agent.ending == "explored" and begun.agent.aim is None


def test_what_is_sure_from_afar_is_not_found_before_it_is_reached(begun, monkeypatch):
    agent, goal = begun.agent, goal_ahead(begun, 1.6)
    begun.agent.exploration.goal = goal
    monkeypatch.setattr(agent.exploration, "look_closely", lambda: Candidate(goal, 1.0, 1.0))
    monkeypatch.setattr(agent.exploration, "take_in", lambda: None)
    monkeypatch.setattr(agent, "_approach", lambda goal: (None, False))  # there is no way
    for _ in range(20):
        begun.step()
    assert agent.ending != "found" and agent.exploration.is_refuted(goal.centroid)


def test_when_nothing_is_left_to_explore_it_looks_at_what_resembles_it_and_then_settles(begun, monkeypatch):
    exploration, looked = begun.agent.exploration, []
    monkeypatch.setattr(exploration, "next_frontier", lambda: None)
    monkeypatch.setattr(exploration, "take_in", lambda: None)
    monkeypatch.setattr(exploration, "look_closely", lambda: looked.append(exploration.goal.centroid))
    places, here = [goal_ahead(begun, ahead).centroid for ahead in (1.5, -1.5)], begun.robot.pose[:2]
    exploration.goal = None
    exploration.alike = [
        Likeness(score, place, Surface(place[None], False, origin=here)) for score, place in zip((0.4, 0.6), places)
    ]
    while not begun.done:
        begun.step()
    assert begun.agent.ending == "guessed" and begun.agent.aim.centroid == pytest.approx(places[1])
    first, last = looked[0], looked[-1]
    assert first == pytest.approx(places[1]) and last == pytest.approx(places[0])
