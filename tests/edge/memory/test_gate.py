from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edge.memory.gate import GateConfig, is_known, judge

CONFIG = GateConfig(
    "novel", 0.9, distance=0.5, angle=radians(30), same_distance=0.2, same_angle=radians(8), disagreement=0.6
)
HERE = np.array([0.0, 0.0, 0.0])


def verdict(offset, cosines, config=CONFIG, answers=True, recent=True):
    poses = np.array([offset], float)
    seen = np.atleast_2d(np.asarray(cosines, float))
    return judge(HERE, poses, np.array([answers]), np.array([recent]), lambda nodes: seen, config)


def test_a_superseded_node_refuses_nothing():
    assert verdict((0.1, 0, 0), 0.99, answers=False) == (True, [])


def test_the_first_view_is_admitted():
    assert judge(HERE, np.empty((0, 3)), np.empty(0, bool), np.empty(0, bool), None, CONFIG) == (True, [])


@pytest.mark.parametrize(
    "offset, cosine, admitted",
    [
        ((0.3, 0, 0), 0.95, False),  # same thing from nearby: Eq. 1 refuses
        ((0.3, 0, 0), 0.85, True),  # something else from nearby
        ((0.6, 0, 0), 0.99, True),  # the same thing from a second place: Eq. 1 as printed would refuse
        ((0.3, 0, radians(31)), 0.99, True),
        ((0.3, 0, 2 * np.pi), 0.99, False),  # angles wrap
    ],
)
def test_equation_1_corrected(offset, cosine, admitted):
    assert verdict(offset, cosine).admit == admitted


def test_one_similar_near_node_is_enough_to_refuse():
    poses = np.array([[0.3, 0, 0], [0.31, 0, 0]])
    both, cosines = np.ones(2, bool), np.array([[0.5], [0.95]])
    assert not judge(HERE, poses, both, both, lambda nodes: cosines[nodes], CONFIG).admit


def test_a_changed_region_supersedes_although_the_whole_picture_agrees():
    assert verdict((0.1, 0, 0), [0.97, 0.98, 0.4, 0.99]) == (True, [0])


@pytest.mark.parametrize("offset", [(0.25, 0, 0), (0, 0, radians(9))])
def test_another_place_cannot_be_contradicted(offset):
    assert verdict(offset, [0.97, 0.1]) == (False, [])


def test_dense_admits_everything_and_still_supersedes():
    dense = GateConfig(policy="dense")
    assert verdict((0, 0, 0), 1.0, dense) == (True, [])
    assert verdict((0, 0, 0), 0.1, dense) == (True, [0])


def test_bad_configurations_are_refused():
    with pytest.raises(ValueError, match="dense"):
        GateConfig(policy="sparse")
    with pytest.raises(ValueError, match="same_distance"):
        GateConfig(same_distance=1.0)


def test_regions_that_a_node_lacks_do_not_count():
    assert verdict((0.1, 0, 0), [0.97, np.nan, 0.9]) == (False, [])


@pytest.mark.parametrize(
    "offset, cosines, superseded",
    [
        ((0.3, 0, 0), [0.95, 0.93, 0.91], [0]),  # nothing in it that the new view does not show
        ((0.3, 0, 0), [0.95, 0.93, 0.85], []),  # one region differs: a cup that is gone, or only hidden from here
        ((0.6, 0, 0), [0.99, 0.99, 0.99], []),  # from a second place
        ((0.1, 0, 0), [0.95, 0.93, 0.4], [0]),  # contradicted
    ],
)
def test_a_view_of_a_later_tour_is_never_known_already(offset, cosines, superseded):
    assert verdict(offset, cosines, recent=False) == (True, superseded)


@pytest.mark.parametrize(
    "offset, whole, known",
    [
        ((0.3, 0, 0), 0.95, True),
        ((0.3, 0, 0), 0.85, False),
        ((0.6, 0, 0), 0.99, False),
        ((0.1, 0, 0), 0.99, False),  # at the same pose a region may contradict it
    ],
)
def test_the_whole_picture_may_tell_that_a_view_is_known(offset, whole, known):
    given = HERE, np.array([offset], float), np.ones(1, bool), np.ones(1, bool), lambda nodes: np.array([[whole]])
    assert is_known(*given, CONFIG) == known


@given(st.integers(0, 2**32 - 1), st.sampled_from(["novel", "dense"]))
def test_what_is_known_by_the_whole_picture_is_refused_whatever_its_regions_show(seed, policy):
    rng, config = np.random.default_rng(seed), GateConfig(policy)
    poses = rng.normal(0, (0.3, 0.3, 0.4), (rng.integers(0, 6), 3))
    answers, recent = rng.random((2, len(poses))) < 0.8
    cosines = rng.uniform(0, 1, (len(poses), 4))
    cosines[:, 0] = rng.choice([0.5, 0.95], len(poses))
    by_whole = is_known(HERE, poses, answers, recent, lambda nodes: cosines[nodes, :1], config)
    verdict = judge(HERE, poses, answers, recent, lambda nodes: cosines[nodes], config)
    assert not (by_whole and verdict.admit)
    same_place = (np.hypot(*poses[:, :2].T) <= config.same_distance) & (np.abs(poses[:, 2]) <= config.same_angle)
    if not verdict.admit and not (same_place & answers).any():
        assert by_whole  # no pass of the image tower is made in vain
