"""What an exploring robot believes, from single pictures."""

import numpy as np
import pytest

from edge.localization.localizer import Localizer, LocalizerConfig
from edge.mapping.object_goal import ObjectGoal, Surface
from edge.missions.exploration import Likeness
from edge.observation import STOP, Twist
from tests.edge.missions.conftest import TO_COUCH, explorer, place_of


def test_what_is_in_view_becomes_the_goal():
    world, robot, exploration = explorer(start=TO_COUCH)
    assert exploration.goal.is_at(place_of(world, "couch-1", TO_COUCH))
    assert exploration.relevance.around(exploration.goal.centroid, 0.3)[0] > 0.8


def test_pictures_from_one_place_count_once():
    world, robot, exploration = explorer(start=TO_COUCH)
    once = exploration.relevance.variance.copy()
    for _ in range(5):
        robot.perceive(world.step(None))
        exploration.take_in()
    assert exploration.relevance.variance == pytest.approx(once)
    while robot.pose[2] < np.radians(8):
        robot.perceive(world.step(Twist(0.0, 0.8)))
        exploration.take_in()
    assert exploration.relevance.variance.min() < 0.9 * once.min()


def test_a_firm_view_of_the_same_thing_is_no_other_goal_and_one_from_afar_no_better_one():
    world, robot, exploration = explorer(start=TO_COUCH)
    exploration.goal = goal = ObjectGoal(Surface(np.array([[1.0, 0.0]]), True))
    firm, elsewhere = Surface(np.array([[1.1, 0.0]]), False), Surface(np.array([[6.0, 3.0]]), False)
    exploration._notice(firm)
    assert exploration.goal is goal and not goal.provisional
    exploration._notice(elsewhere)
    assert exploration.goal is goal
    exploration.goal = ObjectGoal(Surface(np.array([[1.0, 0.0]]), True))
    exploration._notice(elsewhere)
    assert exploration.goal.is_at([6.0, 3.0])


def test_what_was_refuted_is_not_noticed_again():
    world, robot, exploration = explorer(start=TO_COUCH)
    exploration.refute()
    assert exploration.goal is None
    robot.perceive(world.step(STOP))
    exploration.take_in()
    assert exploration.goal is None and not exploration.consider()


def seen_at(x, y=0.0):
    return Surface(np.array([[x, y]]), False)


def test_what_resembles_it_is_considered_once_the_likeliest_first():
    _, _, exploration = explorer("teddy bear")
    for score, x in ((0.4, 1.0), (0.6, 3.0), (0.5, 3.4), (0.7, 1.3)):  # two places, twice each
        exploration._compare(Likeness(score, np.array([x, 0.0]), seen_at(x)))
    assert sorted((alike.score, alike.place[0]) for alike in exploration.alike) == [(0.6, 3.0), (0.7, 1.3)]
    found = []
    while exploration.consider():
        found.append(round(exploration.goal.centroid[0], 1))
        exploration.goal.update(seen_at(exploration.goal.centroid[0], 1.2))  # seen from near, it is elsewhere
        exploration.refute()
    assert found == [1.3, 3.0]


def test_once_refuted_it_may_be_behind():
    _, _, exploration = explorer("teddy bear")
    behind = Surface(np.array([[4.0, 0.0]]), True)
    exploration.goal = ObjectGoal(Surface(np.array([[1.5, 0.0]]), False, behind))
    exploration.refute()
    assert exploration.goal.centroid == pytest.approx([4.0, 0.0])
    exploration.refute()
    assert exploration.goal is None


def test_what_cannot_be_reached_yet_draws_the_robot_to_the_frontier_before_it():
    world, robot, exploration = explorer("teddy bear")
    for place in ([3.0, 0.0], [-3.0, 0.0]):
        exploration.goal = ObjectGoal(Surface(np.array([place]), False))
        found = exploration.next_frontier()
        offered = np.array([frontier.waypoint for frontier in exploration.choice.offered])
        away = np.hypot(*(offered - place).T)
        assert np.hypot(*(found.waypoint - place)) <= 1.1 * away.min() + 1e-6


def test_without_a_picture_nothing_changes():
    world, robot, exploration = explorer(start=TO_COUCH)
    before = exploration.relevance.mean.copy()
    robot.perceive(world.step(STOP, look=False))
    exploration.take_in()
    assert (exploration.relevance.mean == before).all()


def test_a_lost_robot_does_not_heed_its_pictures():
    world, robot, exploration = explorer(start=TO_COUCH)
    exploration.refute()
    before = exploration.relevance.mean.copy()
    robot.localizer = Localizer(config=LocalizerConfig(lost_after=0))  # gives itself up at once
    robot.perceive(world.step(STOP))
    exploration.take_in()
    assert robot.frame is not None and (exploration.relevance.mean == before).all()


def test_furniture_that_only_the_lidar_has_seen_is_looked_at_last(monkeypatch):
    _, robot, exploration = explorer("teddy bear")
    asked = []
    monkeypatch.setattr(
        robot.coverage, "explored", lambda grid, radius: asked.append(radius) or np.zeros(grid.frame.shape, bool)
    )
    assert exploration.next_frontier() is not None and not asked
    while exploration.next_frontier() is not None and not asked:
        exploration.choice.drop(exploration.next_frontier().waypoint)  # there is no way to any other
    assert asked
