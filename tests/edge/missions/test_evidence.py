"""Sightings of places, fused."""

import numpy as np
import pytest

from edge.missions.evidence import SAME, Evidence
from edge.missions.sighting import Sighting
from edge.perception.detection import Detection


def sighting(x, score, depth=2.0):
    return Sighting(0.0, np.zeros(3), Detection((0, 0, 10, 10), score), 0.0, depth, np.array([x, 0.0]))


def test_sightings_of_one_place_are_averaged_and_those_of_another_are_not():
    evidence = Evidence()
    for x, score in ((0.0, 0.9), (SAME / 2, 0.5), (3.0, 0.6)):
        evidence.add(sighting(x, score))
    assert [place.score for place in evidence.places] == pytest.approx([0.7, 0.6])


def test_a_near_look_outweighs_a_far_one():
    evidence = Evidence()
    evidence.add(sighting(0.0, 1.0, depth=3.0))
    place = evidence.add(sighting(0.1, 0.0, depth=1.0))
    assert place.score == pytest.approx(0.1)  # weights 1/9 and 1
    assert place.nearest.depth == 1.0
    assert place.sighting.detection.score == place.score and place.nearest.detection.score == 0.0


def test_a_sighting_counts_for_the_nearest_place():
    evidence = Evidence()
    first, second = evidence.add(sighting(0.0, 0.5)), evidence.add(sighting(SAME * 1.5, 0.5))
    assert first is not second
    assert evidence.add(sighting(SAME, 0.9)) is second


def test_places_are_ranked_by_what_all_looks_say():
    evidence = Evidence()
    for x, score in ((0.0, 0.4), (2.0, 0.8), (4.0, 0.6)):
        evidence.add(sighting(x, score))
    assert [place.score for place in evidence.ranked(0.5)] == [0.8, 0.6]
    assert evidence.ranked(0.9) == []
