"""A small furnished home, and a robot with true eyes that has mapped it."""

from dataclasses import dataclass

import numpy as np
import pytest

from edge.memory.store import Vlpg
from edge.missions.exploration import Exploration
from edge.missions.map_home import MapHome
from edge.perception.prompts import Target, ensemble
from edge.pose import between
from edge.robot import Robot
from firmware_sim.house import House
from firmware_sim.world import World
from tools.eval.oracle import OracleEncoder
from tools.eval.tour import run

PLAN = {
    "name": "two rooms",
    "rooms": [
        {"name": "hall", "category": "Living room", "polygon": [[0, 0], [4, 0], [4, 4], [0, 4]], "floor": "wood"},
        {"name": "den", "category": "Office", "polygon": [[4, 0], [7, 0], [7, 4], [4, 4]], "floor": "carpet"},
    ],
    "walls": [
        {"a": [0, 0], "b": [7, 0]},
        {"a": [7, 0], "b": [7, 4]},
        {"a": [7, 4], "b": [0, 4]},
        {"a": [0, 4], "b": [0, 0]},
        {"a": [4, 0], "b": [4, 1.55]},
        {"a": [4, 2.45], "b": [4, 4]},
    ],
    "doors": [{"a": [4, 1.55], "b": [4, 2.45]}],
    "objects": [
        {"id": "teddy-1", "model": "teddy-bear", "position": [6.4, 3.4]},
        {"id": "couch-1", "model": "couch", "position": [1.5, 3.4]},
        {"id": "armchair-1", "model": "armchair", "position": [3.3, 0.7], "yaw": 2.6},
        {"id": "dustbin-1", "model": "dustbin", "position": [6.6, 0.4]},
    ],
    "start": [2.0, 2.0, 0.0],
}
TO_COUCH = (2.0, 1.5, 1.8)  # looks at the couch, 2 m away


def make_world(seed=0):
    return World(House.from_dict(PLAN), seed)


def make_robot(world):
    encoder = OracleEncoder(world)
    return Robot(encoder, Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim))


def explorer(noun="couch", start=None, kind=Exploration):
    """A robot that has taken in one picture, and goes where the mean is highest."""
    world = World(House.from_dict(PLAN), 0, start=start)
    robot = make_robot(world)
    prompts = robot.encoder.encode_text(ensemble(noun))
    exploration = kind(robot, Target.of(noun, robot.encoder), prompts, lambda means, variances, distances: means)
    robot.perceive(world.step(None))
    exploration.take_in()
    return world, robot, exploration


def place_of(world, thing_id, start):
    """``(2,)``: where a thing is for a robot that began at ``start``."""
    return between(np.asarray(start, float), world.house.objects[thing_id].pose)[:2]


@dataclass
class Mapped:
    world: World
    robot: Robot
    mission: MapHome


@pytest.fixture(scope="package")
def mapped():
    world = make_world()
    robot = make_robot(world)
    mission = MapHome(robot)
    run(world, mission)
    return Mapped(world, robot, mission)
