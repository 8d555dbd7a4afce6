"""Exploring a home that the robot does not know for one thing in it."""

import numpy as np
import pytest

from edge.localization.localizer import Localizer
from edge.mapping.frontiers import Frontier
from edge.mapping.object_goal import ObjectGoal, Surface
from edge.missions.exploration import ExplorationConfig
from edge.missions.explore_for_object import ExploreConfig, ExploreForObject
from edge.missions.find_object import FindObject
from edge.observation import STOP
from edge.perception.prompts import Target
from tests.edge.missions.conftest import make_robot, make_world
from tools.eval.judge import judge
from tools.eval.tour import run


def explore(noun, config=None):
    world = make_world()
    robot = make_robot(world)
    mission = ExploreForObject(robot, Target.of(noun, robot.encoder), config)
    run(world, mission)
    return world, mission


@pytest.fixture(scope="module")
def found():
    return explore("teddy bear")


def test_a_thing_in_another_room_is_found_without_a_map(found):
    world, mission = found
    verdict = judge(world, "teddy bear")
    assert mission.outcome.status == "found" and verdict.in_view and verdict.angular_error < np.radians(10)
    assert mission.outcome.claim.confidence > 0.9 and world.contacts == 0
    assert 5 < mission.outcome.duration < 120


def test_a_claim_that_is_not_sure_is_gone_back_to_when_all_has_been_looked_at():
    world, mission = explore("couch", ExploreConfig(sure=0.995))  # true eyes are sure to 0.99
    assert mission.outcome.status == "found" and mission.outcome.confidence == 0.99
    assert judge(world, "couch").in_view
    viewed, free = mission.robot.coverage.viewed.view(bool), mission.robot.grid.free
    assert (viewed & free).sum() > 0.9 * free.sum()


def test_what_was_seen_on_the_way_is_remembered(found):
    world, mission = found
    asked = FindObject(mission.robot, Target.of("couch", mission.robot.encoder))
    run(world, asked)
    assert asked.outcome.status == "found" and judge(world, "couch").in_view


def test_the_map_of_relevance_is_high_where_the_thing_is(found):
    world, mission = found
    thing = world.house.objects["teddy-1"]
    mean, _ = mission.exploration.relevance.around(np.array([thing.x, thing.y]) - world.house.start[:2], 0.5)
    elsewhere, _ = mission.exploration.relevance.around(np.array([1.5, 3.0]) - world.house.start[:2], 0.5)
    assert mean > elsewhere


def test_what_is_nowhere_is_not_found_and_everything_was_looked_at():
    world, mission = explore("submarine", ExploreConfig(exploration=ExplorationConfig(min_area=0.5)))
    assert mission.outcome.status == "not found" and mission.outcome.confidence == 0
    robot = mission.robot
    assert (robot.coverage.viewed.view(bool) & robot.grid.free).sum() > 0.9 * robot.grid.free.sum()


def test_time_runs_out():
    _, mission = explore("submarine", ExploreConfig(time_limit=5.0))
    assert mission.outcome.status == "timeout" and mission.outcome.duration < 6


def test_after_a_false_alarm_what_it_was_about_to_do_is_left():
    robot, steps = make_robot(make_world()), []
    mission = ExploreForObject(robot, Target.of("teddy bear", robot.encoder))

    def drive():
        for step in range(5):
            steps.append(step)
            yield STOP

    def alarm():
        if len(steps) == 2:
            mission.exploration.goal = ObjectGoal(Surface(np.array([[1.0, 0.0]]), False))

    def reach():
        yield STOP

    mission.exploration.take_in, mission.reach = alarm, reach
    assert list(mission.watching(drive())) == [STOP] * 3 and steps == [0, 1]
    assert mission.exploration.goal is None


class Seeks(ExploreForObject):
    """Explores; ``seen`` has what it does, one word each."""

    def __init__(self, robot, noun, frontiers):
        super().__init__(robot, Target.of(noun, robot.encoder))
        self.seen, self.left = [], list(frontiers)
        self.exploration.take_in = lambda: None
        self.exploration.next_frontier = lambda: self.left.pop(0) if self.left else None
        self.exploration.consider = self.consider

    def consider(self):
        self.seen.append("consider")
        return self.seen.count("consider") < 3

    def visit(self, frontier):
        self.seen.append(frontier)
        yield STOP

    def pursue(self):
        self.seen.append("pursue")
        yield STOP
        return False

    def watching(self, action):
        if action.__name__ == "turn":
            self.seen.append("look around")
            action = iter([STOP])
        return (yield from super().watching(action))


def test_what_it_tries_before_it_gives_up():
    mission = Seeks(make_robot(make_world()), "teddy bear", ["a", None, "b"])
    steps = mission.explore()
    assert not (yield_all(steps))
    around, pursued = ["look around"], ["consider", "pursue"]
    assert mission.seen == [*around, "a", *around, "b", *around, *pursued, *pursued, "consider"]


def yield_all(story):
    """What a story returns."""
    while True:
        try:
            next(story)
        except StopIteration as end:
            return end.value


@pytest.mark.parametrize("lost", [True, False])
def test_a_frontier_is_dropped_when_there_is_no_way_to_it_and_not_when_the_robot_is_lost(monkeypatch, lost):
    def no_way(robot, goal):
        return False
        yield

    monkeypatch.setattr("edge.missions.explore_for_object.drive", no_way)
    robot, dropped = make_robot(make_world()), []
    mission = ExploreForObject(robot, Target.of("teddy bear", robot.encoder))
    robot.localizer = Localizer(lost=lost)
    mission.exploration.choice.drop = dropped.append
    yield_all(mission.visit(Frontier(np.zeros((1, 2)), np.zeros(2))))
    assert bool(dropped) != lost


def test_a_robot_that_is_lost_says_so(monkeypatch):
    world = make_world()
    robot = make_robot(world)
    mission = ExploreForObject(robot, Target.of("teddy bear", robot.encoder))
    observation = world.step(None)
    while robot.distance < 1.0:
        observation = world.step(mission.step(observation))
    robot.localizer = Localizer(lost=True)
    monkeypatch.setattr(robot.localizer, "relocalize", lambda scan, grid: False)
    while not mission.done:
        observation = world.step(mission.step(observation))
    assert mission.outcome.status == "lost" and mission.outcome.duration < 60


def test_its_outcome_has_the_looks_from_aside():
    robot = make_robot(make_world())
    mission = ExploreForObject(robot, Target.of("teddy bear", robot.encoder))
    mission.spotter.replans.append("a look")
    assert mission.ended("not found").replans == ["a look"]
