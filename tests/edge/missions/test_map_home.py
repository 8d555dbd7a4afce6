"""Mapping a small home with every noise on."""

from dataclasses import replace

import numpy as np
import pytest

from edge.missions.map_home import MapHome, MapHomeConfig
from edge.pose import between, compose, wrap
from tests.edge.missions.conftest import make_robot, make_world
from tools.eval.child import in_child
from tools.eval.tour import run


def test_the_tour_ends_complete_and_without_a_collision(mapped):
    assert mapped.mission.outcome.complete
    assert mapped.world.contacts == 0


def test_free_floor_is_that_of_the_house(mapped):
    # 28 m2 less walls, a sofa, an armchair and small things; the doorway's far side is not part of it.
    assert 20 < mapped.mission.outcome.area < 27


def test_the_map_pose_is_the_true_one(mapped):
    truth = between(mapped.world.house.start, mapped.world.truth)
    error = between(mapped.robot.pose, truth)
    assert np.hypot(*error[:2]) < 0.1 and abs(error[2]) < np.radians(3)


@pytest.mark.parametrize("noun", ["teddy bear", "couch", "armchair", "dustbin"])
def test_every_object_is_in_memory_where_it_can_be_seen(mapped, noun):
    robot, house = mapped.robot, mapped.world.house
    wanted, other = robot.encoder.encode_text([f"a photo of {noun}", "a photo of something else"])
    hits = robot.memory.search(wanted - other, 3)
    assert hits.scores[0] > 0
    thing = next(t for t in house.objects.values() if t.model.name.lower() == noun)
    x, y, theta = compose(house.start, robot.memory.poses(hits.ids)[0])
    off = np.arctan2(thing.y - y, thing.x - x) - theta
    # The centre of a wide thing may lie outside a picture that shows its end.
    assert abs(wrap(off)) < robot.camera.hfov / 2 + 0.35


def test_the_same_seed_drives_the_same_way_twice_and_another_does_not():
    def trajectory(seed, steps=90):
        world = make_world(seed)
        mission = MapHome(make_robot(world))
        observation, poses = world.step(None), []
        for _ in range(steps):
            observation = world.step(mission.step(observation))
            poses.append(np.concatenate([world.truth, mission.robot.pose]))
        return np.array(poses)

    first = trajectory(3)
    assert np.array_equal(first, trajectory(3))
    assert not np.array_equal(first, trajectory(4))


def test_a_known_home_is_looked_at_again(mapped):
    again = in_child(toured_again, mapped)
    assert again.complete and again.distance > 3.0 and again.duration > 10.0
    assert again.distance < 2 * mapped.mission.outcome.distance


def toured_again(mapped):
    mission = MapHome(mapped.robot)
    run(mapped.world, mission)
    return mission.outcome


def test_a_tour_forgets_what_was_touched(mapped):
    def begin(mapped):
        mapped.robot.grid.integrate_contact(mapped.robot.pose, mapped.robot.config.radius)
        touched = mapped.robot.grid.occupied.sum()
        mission = MapHome(mapped.robot)
        mission.step(mapped.world.step(None))
        return touched - mapped.robot.grid.occupied.sum()

    assert in_child(begin, mapped) > 3


def test_without_pictures_a_home_is_not_mapped_to_the_end():
    world = make_world()
    mission, observation = MapHome(make_robot(world)), world.step(None)
    for _ in range(200):
        observation = world.step(mission.step(replace(observation, frame=None)))
    assert mission.done and not mission.outcome.complete


def test_its_time_limit_ends_a_tour_in_the_middle_of_a_drive():
    world = make_world()
    mission = MapHome(make_robot(world), MapHomeConfig(time_limit=9.0))
    run(world, mission)
    assert not mission.outcome.complete and mission.outcome.duration == pytest.approx(9.0, abs=0.3)
