"""Asking a robot that knows its home for what is there, what is not, and what has gone."""

from dataclasses import replace
from functools import wraps

import numpy as np
import pytest

from edge.missions import find_object
from edge.missions.find_object import FindObject, FindObjectConfig
from edge.missions.map_home import MapHome
from edge.missions.motion import turn
from edge.observation import STOP
from edge.perception.prompts import Target
from tests.edge.missions.conftest import make_robot, make_world
from tests.edge.planning.fields import field_of_view
from tools.eval.child import in_child
from tools.eval.judge import judge
from tools.eval.tour import run


def apart(test):
    """In a fork of its own: the next test's robot stands where the tour ended, and remembers no more."""

    @wraps(test)
    def in_a_fork(**fixtures):
        in_child(lambda: test(**fixtures))

    return in_a_fork


def ask(mapped, noun, **options):
    mission = FindObject(mapped.robot, Target.of(noun, mapped.robot.encoder), **options)
    run(mapped.world, mission)
    return mission.outcome


@pytest.mark.parametrize("noun", ["teddy bear", "couch"])
@apart
def test_an_object_is_found_centred_and_near(mapped, noun):
    outcome = ask(mapped, noun)
    verdict = judge(mapped.world, noun)
    assert outcome.status == "found" and outcome.confidence == outcome.claim.confidence > 0.9
    assert verdict.in_view and verdict.angular_error < np.radians(10)
    thing = mapped.world.house.objects[verdict.object_id]
    assert np.hypot(*(mapped.world.truth[:2] - (thing.x, thing.y))) < 2.6  # from its centre; a couch is 2 m wide
    assert mapped.world.contacts == 0


@pytest.mark.parametrize("noun", ["teddy bear", "dustbin"])
@apart
def test_what_is_low_is_not_approached_until_it_leaves_the_picture(mapped, noun):
    assert ask(mapped, noun).status == "found"
    assert mapped.world.visible_fraction(judge(mapped.world, noun).object_id) > 0.7


@apart
def test_an_unknown_object_is_not_in_memory_and_the_robot_stays(mapped):
    before = mapped.world.truth
    outcome = ask(mapped, "submarine")
    assert outcome.status == "not in memory"
    assert outcome.hypotheses and all(h.score < 0.5 for h in outcome.hypotheses)
    assert np.allclose(mapped.world.truth, before, atol=0.01)


def test_an_empty_name_is_refused_in_words(mapped):
    with pytest.raises(ValueError, match="what to look for"):
        Target.of("  ", mapped.robot.encoder)


@apart
def test_what_was_taken_away_is_not_claimed(mapped):
    house = mapped.world.house
    taken = house.objects["dustbin-1"]
    house.remove_object("dustbin-1")
    try:
        outcome = ask(mapped, "dustbin", config=FindObjectConfig(hypotheses=1))
    finally:
        house.add_object("dustbin-1", taken.model.id, taken.x, taken.y, taken.yaw)
    assert outcome.status == "not found"
    assert outcome.replans and all(0 <= r.probability.min() and r.probability.max() <= 1 for r in outcome.replans)


@apart
def test_an_improbable_claim_is_made_only_if_asked_for(mapped, monkeypatch):
    monkeypatch.setattr(mapped.robot.encoder, "confidence", lambda seen, remembered: 0.1)
    once = FindObjectConfig(hypotheses=1)
    outcome = ask(mapped, "couch", config=once)
    assert outcome.status == "not found" and outcome.claim is not None and outcome.confidence == 0.1
    assert ask(mapped, "couch", search_unknown=True, config=once).status == "found"


@apart
def test_of_several_claims_the_surest_is_gone_back_to(mapped, monkeypatch):
    stated = []

    def less_each_time(seen, remembered):
        stated.append(0.45 - 0.05 * len(stated))
        return stated[-1]

    first = FindObject.recall
    monkeypatch.setattr(FindObject, "recall", lambda mission: first(mission)[:1] * 2)  # so it is surely seen twice
    monkeypatch.setattr(mapped.robot.encoder, "confidence", less_each_time)
    outcome = ask(mapped, "couch")
    assert len(stated) > 1 and outcome.status == "found" and outcome.confidence == 0.45
    assert judge(mapped.world, "couch").in_view


@apart
def test_a_search_that_runs_out_of_time_tells_its_best_claim(mapped, monkeypatch):
    recall, inspect = FindObject.recall, FindObject.inspect

    def linger_later(mission, hypothesis):
        while mission.best:
            yield STOP
        return (yield from inspect(mission, hypothesis))

    monkeypatch.setattr(FindObject, "recall", lambda mission: recall(mission)[:1] * 2)
    monkeypatch.setattr(FindObject, "inspect", linger_later)
    monkeypatch.setattr(mapped.robot.encoder, "confidence", lambda seen, remembered: 0.4)
    outcome = ask(mapped, "couch", config=FindObjectConfig(time_limit=120.0))
    assert outcome.status == "timeout" and outcome.duration > 120
    assert outcome.confidence == 0.4 and outcome.claim.sighting.detection.score > 0.5


@apart
def test_a_claim_is_gone_back_to_after_places_that_showed_nothing(mapped, monkeypatch):
    inspect, seen, later = FindObject.inspect, [], []

    def turn_away_later(mission, hypothesis):
        if seen:
            later.append(hypothesis)
            yield from turn(mission.robot, np.pi)
            return None
        sighting = yield from inspect(mission, hypothesis)
        seen.extend([sighting] if sighting else [])
        return sighting

    monkeypatch.setattr(mapped.robot.encoder, "confidence", lambda seen, remembered: 0.4)
    monkeypatch.setattr(FindObject, "inspect", turn_away_later)
    assert ask(mapped, "couch").status == "found" and later
    assert judge(mapped.world, "couch").in_view


@apart
def test_a_best_guess_is_the_view_in_memory_where_nothing_is_recognized(mapped, monkeypatch):
    def see_nothing(mission, hypothesis):
        yield from turn(mission.robot, np.pi)

    monkeypatch.setattr(FindObject, "inspect", see_nothing)
    assert ask(mapped, "teddy bear").status == "not found"
    outcome = ask(mapped, "teddy bear", search_unknown=True)
    assert outcome.status == "found" and outcome.claim is None
    assert judge(mapped.world, "teddy bear").in_view


@apart
def test_a_sure_claim_ends_the_search(mapped, monkeypatch):
    stated = []
    monkeypatch.setattr(mapped.robot.encoder, "confidence", lambda *scores: stated.append(scores) or 0.95)
    assert ask(mapped, "teddy bear").status == "found"
    assert len(stated) == 1


@apart
def test_a_search_nearby_knows_where_it_was_looked_in_vain(mapped):
    first = []
    for looked in (False, True):
        mission = FindObject(mapped.robot, Target.of("couch", mapped.robot.encoder))
        hypothesis = mission.recall()[0]
        if looked:
            mission.spotter.in_vain.append(hypothesis.pose)
        next(mission.search_nearby(hypothesis))
        first.append(mission.spotter.replans[0])
    fresh, ruled_out = first
    frame, occupied = fresh.frame, mapped.robot.grid.occupied
    seen = field_of_view(occupied, mapped.robot.grid.frame, hypothesis.pose, mapped.robot.camera)
    row, col = mapped.robot.grid.frame.to_cell(frame.to_world(*np.indices(frame.shape)))
    inside = mapped.robot.grid.frame.contains(row, col)
    in_view = np.zeros(frame.shape, bool)
    in_view[inside] = seen[row[inside], col[inside]]
    likely = in_view & (fresh.probability > 0.5)
    assert likely.sum() > 100
    assert ruled_out.probability[likely].mean() < 0.5 * fresh.probability[likely].mean()
    assert ruled_out.probability[~in_view].mean() == pytest.approx(fresh.probability[~in_view].mean(), rel=0.05)


def test_dead_sensors_are_survived_and_lose_no_map():
    world = make_world()
    mission = MapHome(make_robot(world))
    observation = world.step(None)
    for _ in range(30):
        observation = world.step(mission.step(observation))
    known = mission.robot.grid.free.sum()
    for _ in range(10):
        frame = replace(
            observation.frame,
            rgb=np.zeros_like(observation.frame.rgb),
            depth=np.full_like(observation.frame.depth, np.nan),
        )
        scan = replace(observation.scan, ranges=np.full_like(observation.scan.ranges, np.nan))
        observation = world.step(mission.step(replace(observation, frame=frame, scan=scan)))
    assert np.isfinite(mission.robot.pose).all()
    assert mission.robot.grid.free.sum() >= known


@apart
def test_a_search_nearby_goes_by_the_home_as_it_was_remembered(mapped):
    mission = FindObject(mapped.robot, Target.of("couch", mapped.robot.encoder))
    hypothesis = mission.recall()[0]
    grid, (x, y, heading) = mapped.robot.grid, hypothesis.pose
    line = np.arange(-0.6, 0.6, 0.02)
    ahead, left = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    for place in (x, y) + 0.6 * ahead + line[:, None] * left:  # what the lidar sees of a cupboard brought in since
        grid.integrate_contact(np.array([*place, 0.0]), 0.1)
    beyond = (x, y) + 1.2 * ahead
    in_view = field_of_view(grid.occupied, grid.frame, hypothesis.pose, mapped.robot.camera)
    assert not in_view[grid.frame.to_cell(beyond)]
    next(mission.search_nearby(hypothesis))
    replan = mission.spotter.replans[0]
    assert replan.probability[replan.frame.to_cell(beyond)] > 0.5


@apart
def test_where_it_cannot_drive_to_is_not_tried_again(mapped, monkeypatch):
    def stay(robot, goal, heading=None):
        yield STOP
        return False

    monkeypatch.setattr(find_object, "drive", stay)
    mission = FindObject(mapped.robot, Target.of("couch", mapped.robot.encoder))
    hypothesis = mission.recall()[0]
    monkeypatch.setattr(mission.spotter, "stare", lambda: mission.spotter.in_vain.append(mapped.robot.pose) or iter(()))
    for _ in mission.search_nearby(hypothesis):
        pass
    places = np.array([replan.pose[:2] for replan in mission.spotter.replans])
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))[np.triu_indices(len(places), 1)]
    assert len(places) > 1 and apart.min() > FindObjectConfig.given_up


@apart
def test_a_robot_that_wakes_up_in_a_known_home_finds_its_place_and_the_object(mapped):
    mapped.robot.wake_in(mapped.robot.grid)
    outcome = ask(mapped, "couch")
    assert outcome.status == "found" and judge(mapped.world, "couch").in_view


@apart
def test_a_robot_that_does_not_find_its_place_says_so(mapped):
    mapped.robot.wake_in(mapped.robot.grid)
    mapped.robot.localizer.relocalize = lambda scan, grid: False
    outcome = ask(mapped, "couch")
    assert outcome.status == "lost" and outcome.claim is None and outcome.distance < 0.1
