"""Each disturbance does what it says; the robot answers all the same, and well where it can."""

import numpy as np
import pytest

from edge.pose import between, wrap
from tools.eval import disturbance
from tools.eval.child import in_child
from tools.eval.disturbance import DISTURBANCES, MOVED, Impossible, disturb
from tools.eval.episode import ask


def changed(tour, kind, noun="teddy bear", seed=1):
    """Positions (2,) of things before, things after by id, doors after, and how far off the robot believes to be."""
    things = tour.world.house.objects
    before = {thing.id: np.array([thing.x, thing.y]) for thing in things.values()}
    disturb(kind, tour, noun, seed)
    after = {thing.id: (thing.model.id, np.array([thing.x, thing.y])) for thing in tour.world.house.objects.values()}
    belief = tour.robot.localizer.pose(tour.world.odometry.pose)
    off = between(belief, between(tour.world.house.start, tour.world.truth))
    return before, after, [door.open for door in tour.world.house.doors], off


def test_a_pushed_robot_is_mistaken(tour):
    *_, off = in_child(changed, tour, "push")
    assert 0.02 < np.hypot(*off[:2]) < 0.4 or abs(wrap(off[2])) > 0.02


def test_each_question_is_disturbed_in_its_own_way(tour):
    """Else an evaluation of a hundred questions would measure one push."""
    pushes = [in_child(changed, tour, "push", noun)[-1] for noun in ("teddy bear", "teddy bear", "couch")]
    np.testing.assert_array_equal(pushes[0], pushes[1])
    assert np.abs(pushes[0] - pushes[2]).max() > 0.01


def test_an_occluder_stands_in_the_way(tour):
    before, after, *_ = in_child(changed, tour, "occlude")
    assert after["occluder"][0] == "cupboard"
    assert np.hypot(*(after["occluder"][1] - before["teddy-1"])) < 3


def test_what_an_occluder_would_wall_in_is_left_alone(tour, monkeypatch):
    monkeypatch.setattr(disturbance, "LOOKS", 0)  # nowhere to see it from
    with pytest.raises(Impossible):
        in_child(changed, tour, "occlude")
    assert "occluder" not in tour.world.house.objects


def test_a_displaced_thing_stands_elsewhere_in_its_room(tour):
    before, after, *_ = in_child(changed, tour, "displace")
    assert 0.4 < np.hypot(*(after["teddy-1"][1] - before["teddy-1"])) <= MOVED + 1e-9


def test_a_double_stands_apart(tour):
    before, after, *_ = in_child(changed, tour, "double")
    assert after["double"][0] == "teddy-bear" and np.hypot(*(after["double"][1] - before["teddy-1"])) > 2


def test_a_door_is_shut_unless_the_robot_is_inside(tour):
    inside = tour.world.house.room_at(*tour.world.truth[:2]).name
    other, own = ("teddy bear", "couch") if inside == "hall" else ("couch", "teddy bear")
    *_, doors, _ = in_child(changed, tour, "shut", other)
    assert doors == [False]
    with pytest.raises(Impossible):
        in_child(changed, tour, "shut", own)


@pytest.mark.parametrize("kind", ["push", "displace", "double"])
def test_the_object_is_found_all_the_same(tour, kind):
    assert in_child(ask, tour, "vlpg-nav", "teddy bear", kind, False, 1).success


def test_what_stands_behind_a_cupboard_is_claimed_only_when_some_of_it_shows(tour):
    episode = in_child(ask, tour, "vlpg-nav", "teddy bear", "occlude", False, 1)
    assert episode.status in ("not found", "timeout") or not np.isnan(episode.pixel_error)


def test_what_cannot_be_reached_is_not_claimed(tour):
    inside = tour.world.house.room_at(*tour.world.truth[:2]).name
    episode = in_child(ask, tour, "vlpg-nav", "teddy bear" if inside == "hall" else "couch", "shut", False, 1)
    assert episode.status in ("not found", "timeout") and not episode.success


def test_of_what_is_gone_it_is_right_to_say_so(tour):
    _, after, *_ = in_child(changed, tour, "remove")
    assert "teddy-1" not in after and "couch-1" in after
    episode = in_child(ask, tour, "vlpg-nav", "teddy bear", "remove", False, 1)
    assert episode.success and episode.status == "not found" and episode.confidence == 0


def test_every_disturbance_is_tested():
    assert set(DISTURBANCES) == {"push", "occlude", "displace", "double", "shut", "remove"}
