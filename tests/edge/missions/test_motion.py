import numpy as np
import pytest

from edge.mapping.occupancy import OccupancyGrid
from edge.missions import motion
from edge.missions.mission import Mission
from edge.missions.motion import drive, length, turn
from edge.observation import STOP
from edge.pose import compose, wrap
from firmware_sim.pedestrian import Pedestrian
from tests.edge.missions.conftest import make_robot, make_world
from tools.bench.survey import Sightless, robot_in, survey
from tools.eval.tour import run


def test_length_is_that_of_all_stretches():
    assert length(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])) == 6.0
    assert length(np.zeros((1, 2))) == 0.0


class Drive(Mission):
    def __init__(self, robot, goal, heading):
        self.goal, self.heading = goal, heading
        super().__init__(robot)

    def story(self):
        return (yield from drive(self.robot, self.goal, self.heading))


@pytest.mark.parametrize("heading", [0.3, -2.8])
def test_a_way_that_leads_away_from_the_final_heading_is_driven_to_its_end(heading):
    world = make_world()
    robot = make_robot(world)
    mission = Drive(robot, np.array([-0.7, -0.2]), heading)
    run(world, mission)
    assert mission.outcome is True
    np.testing.assert_allclose(robot.pose[:2], [-0.7, -0.2], atol=0.12)
    assert abs(wrap(robot.pose[2] - heading)) < 0.1


class Turn(Mission):
    def story(self):
        yield from turn(self.robot, np.pi)
        return "ended"


def test_a_turn_that_does_not_turn_is_given_up():
    world = make_world()
    world.base.advance = lambda *given, **more: None  # its wheels are blocked
    mission = Turn(make_robot(world))
    run(world, mission)
    assert mission.outcome == "ended" and abs(world.truth[2]) < 0.1


@pytest.fixture(scope="module")
def known():
    """The map of the two rooms."""
    return survey(make_world().house).to_bytes()


@pytest.mark.parametrize("late", [0.0, 0.8])
def test_it_gives_way_to_a_person_who_crosses(known, late):
    world = make_world(1)
    robot = robot_in(world, known, Sightless())
    # On its way through the hall to the doorway; the person comes from the middle of the hall's south.
    world.admit(Pedestrian(np.array([[2.9, 3.0], [2.6, 0.6]]), 0.8, departure=late))
    mission = Drive(robot, np.array([5.0, 2.0]), None)
    run(world, mission)
    assert mission.outcome is True and world.contacts == 0


def test_it_waits_as_long_as_somebody_walks_about_in_its_way(known):
    """To and fro before the doorway, for longer than its patience with a way that gets no shorter."""
    world = make_world(1)
    robot = robot_in(world, known, Sightless())
    world.admit(Pedestrian(np.array([[3.4, 2.4], [3.4, 1.6]] * 5 + [[3.4, 3.3]]), 0.5))
    mission = Drive(robot, np.array([5.5, 2.0]), None)
    run(world, mission)
    assert mission.outcome is True and world.contacts == 0 and robot.stamp > 8


def test_carried_elsewhere_it_finds_its_place_and_the_way(known):
    world = make_world(1)
    robot = robot_in(world, known, Sightless())
    robot.wake_in(robot.grid)
    robot.localizer.move(np.zeros(3), np.array([3.0, 0.5, 2.0]))  # whatever it believed
    mission = Drive(robot, np.array([5.5, 2.0]), None)
    run(world, mission)
    assert mission.outcome is True and world.contacts == 0
    np.testing.assert_allclose(robot.pose[:2], world.truth[:2], atol=0.05)


def test_the_time_that_it_looks_for_its_place_is_not_held_against_the_way(known):
    """It goes astray, believes to be nearer than it is, and needs longer than its patience to notice where it is."""
    world = make_world(1)
    robot = robot_in(world, known, Sightless())
    mission = Drive(robot, np.array([5.5, 2.0]), None)
    seen = world.step(None)
    while robot.distance < 1.0:
        seen = world.step(mission.step(seen))
    robot.localizer.move(robot.pose, compose(robot.pose, np.array([1.0, 0.0, 0.0])))
    for _ in range(11):  # until it has planned from there
        seen = world.step(mission.step(seen))
    robot.wake_in(robot.grid)
    found, lost = robot.localizer.relocalize, robot.stamp
    robot.localizer.relocalize = lambda *given: robot.stamp - lost > 7.0 and found(*given)
    run(world, mission)
    assert mission.outcome is True and robot.stamp - lost > 7.0


def give_up(monkeypatch, ways):
    """When a drive is given up [s] whose way is ``ways(stamp)`` long [m]; nothing else matters here."""
    robot = make_robot(make_world())
    monkeypatch.setattr(motion, "route", lambda robot, goal, config: np.array([[0.0, 0.0], [ways(robot.stamp), 0.0]]))
    monkeypatch.setattr(motion, "steer", lambda *given, **more: STOP)
    story = drive(robot, np.zeros(2))
    for _ in story:
        robot.stamp += 0.1
        if robot.stamp > 60:
            break
    return robot.stamp


def test_a_way_that_turns_out_to_be_longer_is_driven(monkeypatch):
    """A door is shut after 2 s: there is another way of 10 m, and it is driven at 0.5 m/s until something stops it."""
    assert give_up(monkeypatch, lambda t: 4.0 - 0.5 * t if t < 2 else max(10.0 - 0.5 * t, 5.0)) == pytest.approx(
        16, abs=2
    )


def test_ways_that_change_for_ever_are_given_up(monkeypatch):
    assert give_up(monkeypatch, lambda t: 4.0 if t % 10 < 5 else 6.0) < 40


def test_where_it_cannot_find_its_place_it_does_not_drive(known):
    world = make_world(1)
    robot = robot_in(world, known, Sightless())
    robot.wake_in(robot.grid)
    robot.localizer.relocalize = lambda scan, grid: False
    mission = Drive(robot, np.array([5.5, 2.0]), None)
    start = world.truth[:2].copy()
    run(world, mission)
    assert mission.outcome is False and np.hypot(*(world.truth[:2] - start)) < 0.05


@pytest.mark.parametrize("push", [(0.28, -0.08, -0.16), (-0.2, 0.2, 0.1), (0.0, -0.3, 0.0)])
def test_pushed_aside_it_knows_where_it_is_before_its_map_agrees_with_a_wrong_place(known, push):
    world = make_world(1)
    robot = robot_in(world, known, Sightless())
    robot.localizer.move(robot.pose, compose(robot.pose, np.array(push)))
    mission = Drive(robot, np.array([5.5, 2.0]), None)
    run(world, mission)
    assert mission.outcome is True
    np.testing.assert_allclose(robot.pose[:2], world.truth[:2], atol=0.05)
    # Nor does its camera draw furniture where it is not, while it stands and until it knows.
    old, grid = OccupancyGrid.from_bytes(known), robot.grid
    places = grid.frame.to_world(*np.nonzero(grid.occupied))
    assert old.clearance()[old.frame.to_cell(places)].max() < 0.15
