"""A thing in an open hall, with views around it that know by geometry whether they show it."""

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.memory.gate import GateConfig
from edge.memory.nodes import COLUMNS
from edge.memory.recall import recall
from edge.memory.store import Vlpg, VlpgConfig
from edge.pose import wrap

CAMERA = CameraModel()
WINDOWS = np.array([0.0, 0.39, 0.0, -0.39])  # the whole picture, then its windows from left to right
CUP, LAMP, ELSE = np.eye(3, dtype=np.float32)
SPOT, OTHER_SPOT, FAR_SPOT = np.array([0.0, 0.0]), np.array([0.0, 2.5]), np.array([20.0, 0.0])


class Hall:
    """A store, to which tours add views of the cup, the lamp or neither."""

    def __init__(self):
        self.store = Vlpg.open(":memory:", "tower", "ab", 3, VlpgConfig(gate=GateConfig("dense", disagreement=-1.0)))

    def tour(self, cup=None, lamp=SPOT, around=SPOT, views=8, reach=5.0, distance=1.8):
        """``views`` from a circle around a spot towards its middle; ``cup`` and ``lamp`` are where they stand."""
        self.store.begin_tour()
        for angle in np.linspace(0, 2 * np.pi, views, endpoint=False):
            pose = np.array([*(around + distance * np.array([np.cos(angle), np.sin(angle)])), wrap(angle + np.pi)])
            shown = [ELSE + sum(thing * self.shows(pose, spot) for thing, spot in ((CUP, cup), (LAMP, lamp)))]
            shown += [
                ELSE + sum(thing * self.shows(pose, spot, middle) for thing, spot in ((CUP, cup), (LAMP, lamp)))
                for middle in WINDOWS[1:]
            ]
            rows = np.array([vector / np.linalg.norm(vector) for vector in shown])
            far = np.full(COLUMNS, reach)
            assert self.store.add(0.0, pose, np.eye(3) * 1e-4, rows, WINDOWS, reach=far) is not None
        return self

    @staticmethod
    def shows(pose, spot, middle=None):
        if spot is None:
            return 0.0
        eye = pose[:2] + CAMERA.ahead * np.array([np.cos(pose[2]), np.sin(pose[2])])
        off = wrap(np.arctan2(*(spot - eye)[::-1]) - pose[2])
        near = np.hypot(*(spot - eye)) < 5.0
        inside = abs(off) < CAMERA.hfov / 2 if middle is None else abs(off - middle) < 0.39
        return 2.0 * (near and inside)

    def tours_that_see(self, thing=CUP):
        """Tours whose hits stand and speak for the thing."""
        hits = recall(self.store, thing - ELSE, 200, CAMERA)
        return sorted(set(self.store.tours(hits.ids[hits.scores > 0]).tolist()))


def test_on_the_first_tour_all_hits_stand():
    hall = Hall().tour(cup=SPOT)
    for hits, all_hits in zip(recall(hall.store, CUP - ELSE, 20, CAMERA), hall.store.search(CUP - ELSE, 20)):
        np.testing.assert_array_equal(hits, all_hits)


def test_what_is_gone_is_no_longer_remembered_and_what_stayed_beside_it_is():
    hall = Hall().tour(cup=SPOT).tour(cup=None)
    assert hall.store.search(CUP - ELSE, 1).scores[0] > 0.3
    assert hall.tours_that_see(CUP) == [] and hall.tours_that_see(LAMP) == [1, 2]


def test_what_was_moved_is_remembered_where_it_is_now():
    hall = Hall().tour(cup=SPOT).tour(cup=OTHER_SPOT).tour(cup=OTHER_SPOT, around=OTHER_SPOT)
    assert hall.tours_that_see() == [2, 3]


def test_many_views_of_where_it_was_leave_room_for_where_it_is():
    hall = Hall().tour(cup=SPOT, lamp=None, views=24)
    hall.tour(cup=OTHER_SPOT, lamp=OTHER_SPOT).tour(cup=OTHER_SPOT, lamp=OTHER_SPOT, around=OTHER_SPOT)
    assert hall.store.tours(hall.store.search(CUP - ELSE, 20).ids).max() == 1
    hits = recall(hall.store, CUP - ELSE, 20, CAMERA)
    assert len(hits.ids) == 20 and hall.store.tours(hits.ids)[hits.scores > 0].min() > 1


@pytest.mark.parametrize(
    "tour",
    [
        {"around": FAR_SPOT},  # nobody went there again
        {"reach": 0.8},  # something stood in the way
        {"reach": 0.0},  # how far the view went is not known
        {"distance": 4.5},  # too far to tell
        {"views": 1},  # a single view may be mistaken
    ],
)
def test_who_did_not_look_from_near_has_no_vote(tour):
    assert Hall().tour(cup=SPOT).tour(cup=None, **tour).tours_that_see() == [1]


def test_what_has_come_back_counts_again():
    hall = Hall().tour(cup=SPOT).tour(cup=None).tour(cup=SPOT, distance=1.3)
    assert hall.tours_that_see() == [1, 3]


def test_a_view_that_ended_before_the_lens_still_claims_what_is_there():
    assert Hall().tour(cup=SPOT, reach=0.04).tour(around=FAR_SPOT).tours_that_see() == [1]


def test_an_empty_memory_has_no_hits():
    assert len(recall(Hall().store, CUP - ELSE, 5, CAMERA).ids) == 0
