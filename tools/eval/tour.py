"""A home that has been mapped: where every episode of an evaluation begins."""

from dataclasses import dataclass, field

import numpy as np

from edge.memory.store import Vlpg
from edge.missions.map_home import HomeMapped, MapHome
from edge.perception.encoder import Encoder
from edge.robot import Robot
from firmware_sim.home import load_home
from firmware_sim.house import House
from firmware_sim.world import World
from tools.eval.oracle import OracleEncoder
from tools.eval.truth import TrueLocalizer

# What the camera, 0.88 m high, can see: whatever stands lower than the top of its picture 1 m away.
HIGHEST = 1.5  # m
SEEN = 0.004  # of the picture's pixels: what covers less is too small to count as seen


@dataclass
class Tour:
    """A world, and a robot in it that knows the home."""

    world: World
    robot: Robot
    mapped: HomeMapped
    in_view: set[str] = field(default_factory=set)  # names of what the robot's camera has had in view
    truth: str = ""  # the part of the robot, one of TRUTHS, that knows the truth


def map_home(home: str, encoder: str, seed: int, truth: str = "") -> Tour:
    """Map ``home`` (a name, a file, "generated:7") with the ``encoder`` (a model's name, or "oracle").

    ``seed`` is of all noise; ``truth`` names the part of the robot, one of TRUTHS, that knows it. Raises HouseError or
    ModelError when there is no such home or model.
    """
    world = World(load_home(home), seed)
    true = encoder == "oracle" or truth == "encoder"
    robot = new_robot(world, OracleEncoder(world) if true else Encoder.load(encoder))
    if truth == "pose":
        robot.localizer = TrueLocalizer(world)
    mission, seen = MapHome(robot), set()
    run(world, mission, lambda: seen.update(names_in_view(world)))
    return Tour(world, robot, mission.outcome, seen, truth)


def new_robot(world: World, encoder) -> Robot:
    """A robot that knows nothing yet, its memory in RAM."""
    memory = Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim)
    return Robot(encoder, memory, world.config.camera_model)


def run(world: World, mission, after_step=lambda: None) -> None:
    """Lock-step until the mission is done and the robot stands still."""
    observation = world.step(None)
    while not mission.done or abs(observation.twist).max() > 0.02:
        observation = world.step(mission.step(observation))
        after_step()


def names_in_view(world: World) -> set[str]:
    """Names, in lower case, of the things that the newest picture shows well enough to be seen."""
    instances = world.picture.instances
    pixels = np.bincount(instances[instances >= 0].ravel(), minlength=len(world.object_ids))
    things = world.house.objects
    shown = (world.object_ids[i] for i in np.flatnonzero(pixels > SEEN * instances.size))
    return {things[thing].model.name.lower() for thing in shown if thing in things}


def nouns(house: House) -> list[str]:
    """Names of the objects that stand on the floor or on furniture at a height that the camera sees."""
    return sorted({thing.model.name.lower() for thing in house.objects.values() if thing.elevation < HIGHEST})
