import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.memory.gate import GateConfig
from edge.memory.thinning import most_redundant

GATE = GateConfig()


def alike(older, newer):
    return np.ones(len(older))


def test_of_two_views_of_one_place_the_older_goes():
    poses = np.array([[0, 0, 0], [3, 0, 0], [3.1, 0.1, 0.1], [9, 9, 1.0]])
    assert most_redundant(poses, alike, GATE) == 1


def test_among_equally_crowded_places_those_that_saw_the_same_twice_make_room():
    poses = np.array([[0, 0, 0], [0.1, 0, 0], [3, 0, 0], [3.1, 0, 0]])
    assert most_redundant(poses, lambda older, newer: np.where(older == 2, 0.9, 0.3), GATE) == 2


def test_the_most_crowded_place_makes_room_first_even_if_another_saw_the_same_twice():
    poses = np.array([[0, 0, 0], [0.1, 0, 0], [3, 0, 0], [3.1, 0, 0], [3.2, 0, 0]])
    assert most_redundant(poses, lambda older, newer: np.where(older == 0, 1.0, 0.2 + older / 100), GATE) == 3


def test_looking_the_other_way_is_another_place():
    poses = np.array([[0, 0, 0], [0, 0, np.pi], [5, 0, 0], [5, 0, 0.1]])
    assert most_redundant(poses, alike, GATE) == 2


def test_when_every_place_has_one_view_the_densest_ones_thin_out():
    poses = np.array([[0, 0, 0], [0.9, 0, 0], [8, 0, 0], [16, 0, 0]])
    assert most_redundant(poses, alike, GATE) == 0


@settings(max_examples=50, deadline=None)
@given(st.integers(2, 60), st.integers(0, 2**32 - 1))
def test_the_newest_view_stays_and_so_does_the_only_one_of_a_room(count, seed):
    rng = np.random.default_rng(seed)
    poses = np.column_stack([rng.uniform(0, 4, (count, 2)), rng.uniform(-np.pi, np.pi, count)])
    poses[0, :2] = 40.0
    gone = most_redundant(poses, lambda older, newer: rng.uniform(-1, 1, len(older)), GATE)
    assert gone != count - 1 and (gone != 0 or count == 2)
