"""A choice that follows the scores, but does not dither and does not insist."""

import numpy as np
import pytest

from edge.mapping.frontiers import Frontier
from edge.planning.frontier_choice import ChoiceConfig, FrontierChoice


class Beliefs:
    """Mean relevance by waypoint."""

    def __init__(self, **means):
        self.means = means

    def around(self, place, radius):
        return self.means.get(f"x{place[0]:.0f}", 0.5), 0.01


def at(x, y=0.0):
    return Frontier(np.array([[x, y]]), np.array([x, y], float))


def by_mean(means, variances, away):
    return means


HERE = np.zeros(3)


def test_the_best_score_is_chosen_and_told():
    choice = FrontierChoice(by_mean)
    found = choice.choose([at(2), at(5), at(9)], Beliefs(x2=0.1, x5=0.9, x9=0.3), HERE)
    assert found.waypoint[0] == 5 and choice.scores == pytest.approx([0.1, 0.9, 0.3])


def test_a_slightly_better_one_does_not_turn_the_robot_round_and_a_clearly_better_one_does():
    choice, three = FrontierChoice(by_mean), [at(2), at(5), at(9)]
    assert choice.choose(three, Beliefs(x2=0.1, x5=0.8, x9=0.7), HERE).waypoint[0] == 5
    assert choice.choose(three, Beliefs(x2=0.1, x5=0.75, x9=0.8), HERE).waypoint[0] == 5
    assert choice.choose(three, Beliefs(x2=0.1, x5=0.7, x9=0.8), HERE).waypoint[0] == 9


def test_a_frontier_that_shrank_is_the_same_one():
    choice = FrontierChoice(by_mean)
    assert choice.choose([at(2), at(5)], Beliefs(x2=0.1, x5=0.8), HERE).waypoint[0] == 5
    assert choice.choose([at(2), at(5, 0.8)], Beliefs(x2=0.82, x5=0.8), HERE).waypoint[0] == 5
    assert choice.choose([at(2, 3), at(5, 0.8), at(9)], Beliefs(x2=0.1, x5=0.8, x9=0.82), HERE).waypoint[0] == 5


def test_what_is_not_approached_is_put_off():
    choice = FrontierChoice(by_mean, ChoiceConfig(patience=3))
    both, beliefs = [at(2), at(5)], Beliefs(x2=0.1, x5=0.9)
    chosen = [choice.choose(both, beliefs, HERE).waypoint[0] for _ in range(6)]
    assert chosen == [5, 5, 5, 5, 2, 2]


def test_what_is_approached_is_kept():
    choice = FrontierChoice(by_mean, ChoiceConfig(patience=3))
    beliefs = Beliefs(x2=0.1, x9=0.9)
    for x in np.arange(0, 8, 0.5):
        assert choice.choose([at(2), at(9)], beliefs, np.array([x, 0, 0])).waypoint[0] == 9


def test_without_frontiers_there_is_no_choice():
    choice = FrontierChoice(by_mean)
    assert choice.choose([], Beliefs(), HERE) is None
    choice.drop([5.0, 0.0])
    assert choice.choose([at(5)], Beliefs(), HERE) is None


def test_of_equal_promise_the_nearest_is_chosen():
    choice = FrontierChoice(by_mean)
    assert choice.choose([at(9), at(2), at(5)], Beliefs(x2=0.79, x5=0.5, x9=0.8), HERE).waypoint[0] == 2
    strict = FrontierChoice(by_mean, ChoiceConfig(tie=0))
    assert strict.choose([at(9), at(2)], Beliefs(x2=0.79, x9=0.8), HERE).waypoint[0] == 9


def test_what_leads_to_a_place_is_chosen_whatever_its_promise():
    choice = FrontierChoice(by_mean)
    assert choice.choose_toward([at(2), at(5), at(9)], np.array([6.0, 0.0]), HERE).waypoint[0] == 5
    assert choice.choose_toward([], np.array([6.0, 0.0]), HERE) is None


def test_a_way_that_leads_away_at_first_is_progress_and_to_and_fro_is_not():
    round_about = FrontierChoice(by_mean, ChoiceConfig(patience=3))
    for y in np.arange(0, 8, 0.5):
        assert round_about.choose([at(9)], Beliefs(), np.array([0.0, y])) is not None
    dithering = FrontierChoice(by_mean, ChoiceConfig(patience=3))
    chosen = [dithering.choose([at(9)], Beliefs(), np.array([0.0, 0.5 * (step % 2)])) for step in range(12)]
    assert chosen[8] is not None and chosen[-1] is None  # it gets a second chance


def test_two_that_take_turns_without_progress_are_dropped():
    choice = FrontierChoice(by_mean, ChoiceConfig(patience=3))
    beliefs = [Beliefs(x2=0.1, x9=0.9), Beliefs(x2=0.9, x9=0.1)]
    chosen = [choice.choose([at(2), at(9)], beliefs[step % 2], HERE) for step in range(24)]
    waypoints = [frontier and frontier.waypoint[0] for frontier in chosen]
    assert waypoints[:6] == [9, 2] * 3 and waypoints[8:11] == [2, 2, 2]  # one waits, the other is not to blame
    assert 9 in waypoints[11:] and waypoints[-1] is None


def test_one_that_was_left_for_another_for_long_may_be_made_for_anew():
    choice, both = FrontierChoice(by_mean, ChoiceConfig(patience=3)), [at(2), at(9)]
    for _ in range(3):
        assert choice.choose(both, Beliefs(x2=0.1, x9=0.9), HERE).waypoint[0] == 9
    for x in np.arange(0, 3, 0.5):
        assert choice.choose(both, Beliefs(x2=0.9, x9=0.1), np.array([x, 0, 0])).waypoint[0] == 2
    for _ in range(4):
        assert choice.choose(both, Beliefs(x2=0.1, x9=0.9), HERE).waypoint[0] == 9


def test_how_long_choices_last_is_no_matter_on_the_way_to_a_place():
    choice = FrontierChoice(by_mean, ChoiceConfig(tie=0.0, margin=np.inf))
    both = [at(6), at(-4)]
    assert choice.choose(both, Beliefs(x6=0.9), HERE).waypoint[0] == 6
    assert choice.choose(both, Beliefs(x6=0.1), HERE).waypoint[0] == 6
    assert choice.choose_toward(both, np.array([-5.0, 0.0]), HERE).waypoint[0] == -4
