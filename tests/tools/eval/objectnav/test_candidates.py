"""What close looks take for the object."""

import numpy as np

from edge.mapping.object_goal import ObjectGoal, Surface
from edge.missions.exploration import Likeness
from tests.edge.missions.conftest import TO_COUCH, explorer, place_of
from tools.eval.objectnav.candidates import Candidate, CandidateExploration


def before_the_couch():
    world, _, exploration = explorer(start=TO_COUCH, kind=CandidateExploration)
    return place_of(world, "couch-1", TO_COUCH), exploration


def alike(score, x):
    return Likeness(score, np.array([x, 0.0]), Surface(np.array([[x, 0.0]]), False))


def test_a_close_look_confirms_it():
    couch, exploration = before_the_couch()
    found = exploration.look_closely()
    assert found is exploration.best and found.score > 0.9 and found.confidence == 0.99
    assert found.goal.is_at(couch) and exploration.is_settled()


def test_a_close_look_elsewhere_does_not_confirm_the_goal_but_moves_it():
    couch, exploration = before_the_couch()
    exploration.goal = ObjectGoal(Surface(np.array([[2.5, -1.5]]), False))
    assert exploration.look_closely() is None
    assert exploration.goal.is_at(couch) and exploration.best.goal.is_at(couch)


def test_where_a_look_saw_it_stays_when_later_views_move_the_goal():
    couch, exploration = before_the_couch()
    found = exploration.look_closely()
    exploration.goal.update(Surface(np.array([[0.0, -3.0]]), False))
    assert found.goal.is_at(couch) and not exploration.is_settled()


def test_guesses_are_what_was_looked_at_closely_by_confidence_then_what_resembles_it():
    _, exploration = before_the_couch()
    exploration.alike = [alike(score, x) for score, x in ((0.5, 1.0), (0.8, 2.0), (0.9, 7.0))]
    exploration.goal = ObjectGoal(exploration.alike[2].seen)
    exploration.refute()
    for confidence, x in ((0.3, 3.0), (0.6, 4.0), (0.2, 5.0)):
        exploration.candidates.append(Candidate(ObjectGoal(Surface(np.array([[x, 0.0]]), False)), 0.9, confidence))
    assert [goal.centroid[0] for goal in exploration.guesses] == [4.0, 3.0, 5.0, 2.0, 1.0, 7.0]
