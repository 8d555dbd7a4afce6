from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from edge.camera import CameraModel
from firmware_sim.house import House
from tools.demo.verdict import judgement


def world(truth, visible):
    """What a judge sees of the apartment: the robot at ``truth``, and each thing's visible share."""
    return SimpleNamespace(
        house=House.load("apartment"),
        truth=np.array(truth, float),
        config=SimpleNamespace(camera_model=CameraModel()),
        visible_fraction=lambda object_id: visible.get(object_id, 0.0),
    )


@pytest.fixture
def beside_the_bear():
    """A pose 1 m west of the teddy bear that looks at it."""
    bear = House.load("apartment").objects["teddy-bear-1"]
    return bear.x - 1.0, bear.y, 0.1


def test_a_thing_in_view_confirms_the_claim(beside_the_bear):
    found = judgement(world(beside_the_bear, {"teddy-bear-1": 0.8}), "the teddy bear", True)
    assert found.verdict == "confirmed"
    assert found.angular_error == pytest.approx(0.1, abs=1e-9)
    assert found.remark == "The teddy bear (teddy-bear-1) is in view, 80% of it visible."


@pytest.mark.parametrize("visible", [0.0, 0.1])
def test_a_hidden_thing_makes_the_claim_wrong(beside_the_bear, visible):
    assert judgement(world(beside_the_bear, {"teddy-bear-1": visible}), "teddy bear", True).verdict == "wrong"


def test_a_thing_behind_the_robot_makes_the_claim_wrong(beside_the_bear):
    x, y, theta = beside_the_bear
    found = judgement(world((x, y, theta + pi), {"teddy-bear-1": 1.0}), "teddy bear", True)
    assert found.verdict == "wrong"


def test_no_claim_is_never_wrong(beside_the_bear):
    assert judgement(world(beside_the_bear, {}), "teddy bear", False).verdict == "no claim"
    assert judgement(world(beside_the_bear, {}), "elephant", False).verdict == "no claim"


def test_a_claim_of_what_the_home_has_not_is_wrong(beside_the_bear):
    found = judgement(world(beside_the_bear, {}), "elephant", True)
    assert found.verdict == "wrong"
    assert found.remark == "Nothing in this home is called elephant."
    assert found.angular_error is None and found.true_positions == []


def test_another_name_of_the_thing_will_do():
    couch = House.load("apartment").objects["couch-1"]
    found = judgement(world((couch.x - 1.0, couch.y, 0.0), {"couch-1": 0.5}), "sofa", True)
    assert found.verdict == "confirmed"
    assert found.true_positions == [(couch.x, couch.y)]
