"""What may go wrong between the mapping of a home and a question about it."""

from math import cos, hypot, pi, radians, sin
from zlib import crc32

import numpy as np

from edge.missions.find_object import FindObject
from edge.perception.prompts import Target
from edge.pose import compose, transform, wrap
from firmware_sim.free_space import FreeSpace
from firmware_sim.furnish import PASSAGE
from firmware_sim.house import HouseError, HouseObject
from firmware_sim.placement import ROBOT_RADIUS, what_blocks
from tools.eval.judge import VISIBLE_SHARE, instances_of
from tools.eval.tour import Tour

PUSHED = 0.3, radians(10)  # m, rad; the robot believes to be up to this far from where it is
MOVED = 2.0  # m, at most, that a thing is displaced
OCCLUDERS = "cupboard", "bookcase"  # 1 m wide and 1.5 m high: what stands behind one is hidden from the camera
TRIES = 300
LOOKS = 100  # places from which a thing must be in view at least once, or it counts as walled in


class Impossible(RuntimeError):
    """This question cannot be disturbed in this way: nothing fits where it would have to be."""


def disturb(kind: str, tour: Tour, noun: str, seed: int) -> None:
    """Change the world, or what the robot believes, before ``noun`` is asked for; ``kind`` is one of DISTURBANCES.

    Each question is disturbed in its own way, the same for all methods.

    Raises:
        Impossible: there is no room for the change.
    """
    question = crc32(f"{tour.world.house.name}/{noun}".encode())
    DISTURBANCES[kind](tour, noun, np.random.default_rng([seed, question]))


def push(tour: Tour, noun: str, rng) -> None:
    """The robot is up to 0.3 m and 10 degrees away from where it believes to be."""
    distance, direction = PUSHED[0] * np.sqrt(rng.uniform()), rng.uniform(-pi, pi)
    shift = np.array([distance * cos(direction), distance * sin(direction), rng.uniform(-1, 1) * PUSHED[1]])
    robot = tour.robot
    robot.localizer.move(robot.pose, compose(robot.pose, shift))


def occlude(tour: Tour, noun: str, rng) -> None:
    """A cupboard stands between the first viewpoint and the object, which can be seen from elsewhere."""
    robot, world = tour.robot, tour.world
    mission = FindObject(robot, Target.of(noun, robot.encoder))
    hypotheses = mission.recall()
    if not hypotheses:
        raise Impossible(f"the memory has no viewpoint for {noun}")
    view = transform(world.house.start, hypotheses[0].pose[None, :2])[0]
    thing = min(instances_of(tour.world.house, noun), key=lambda thing: hypot(thing.x - view[0], thing.y - view[1]))
    model = next(model for model in OCCLUDERS if model != thing.model.id and model.replace("-", " ") != noun)
    line = np.array([thing.x, thing.y]) - view
    across = float(np.arctan2(line[1], line[0])) - pi / 2
    for share in (0.6, 0.5, 0.7, 0.4, 0.8):
        for aside in (0.0, 0.15, -0.15):
            x, y = view + share * line + aside * np.array([cos(across), sin(across)])
            if _stand(tour, "occluder", model, x, y, across):
                if _can_be_seen(tour, noun, rng):
                    return
                tour.world.house.remove_object("occluder")
    raise Impossible(f"nothing fits between the viewpoint and {noun}")


def displace(tour: Tour, noun: str, rng) -> None:
    """The object, and every other of its name, stands up to 2 m from where the tour saw it."""
    for thing in instances_of(tour.world.house, noun):
        for _ in range(TRIES):
            distance, direction = rng.uniform(0.5, MOVED), rng.uniform(-pi, pi)
            x, y = thing.x + distance * cos(direction), thing.y + distance * sin(direction)
            if _same_room(tour, thing, x, y) and _move(tour, thing, x, y, rng.uniform(-pi, pi)):
                break
        else:
            raise Impossible(f"there is no room for {noun} elsewhere")


def double(tour: Tour, noun: str, rng) -> None:
    """A second object of the same model stands somewhere else in the home."""
    thing = instances_of(tour.world.house, noun)[0]
    low, high = tour.world.house.bounds
    for _ in range(TRIES):
        x, y = rng.uniform(low, high)
        if hypot(x - thing.x, y - thing.y) > 2.0 and _stand(tour, "double", thing.model.id, x, y, rng.uniform(-pi, pi)):
            return
    raise Impossible(f"there is no room for a second {noun}")


def shut(tour: Tour, noun: str, rng) -> None:
    """The doors of the object's room are closed, unless the robot is in it: it cannot be reached."""
    house = tour.world.house
    thing = instances_of(tour.world.house, noun)[0]
    room, here = house.room_at(thing.x, thing.y), house.room_at(*tour.world.truth[:2])
    if room is here:
        raise Impossible(f"the robot is in the room of {noun}")
    for number, door in enumerate(house.doors):
        a, b = np.array(door.a), np.array(door.b)
        side = np.array([a[1] - b[1], b[0] - a[0]]) / np.hypot(*(b - a)) * 0.3
        if any(house.room_at(*((a + b) / 2 + sign * side)) is room for sign in (1, -1)):
            house.set_door(number, open=False)


def remove(tour: Tour, noun: str, rng) -> None:
    """The object is gone, and every other of its name: "not here" is the right answer."""
    house = tour.world.house
    for thing in instances_of(house, noun):
        if house.standing_on(thing.id):
            raise Impossible(f"something stands on {noun}")
        house.remove_object(thing.id)


DISTURBANCES = {
    "push": push,
    "occlude": occlude,
    "displace": displace,
    "double": double,
    "shut": shut,
    "remove": remove,
}


def _same_room(tour: Tour, thing: HouseObject, x: float, y: float) -> bool:
    house = tour.world.house
    return house.room_at(x, y) is house.room_at(thing.x, thing.y)


def _stand(tour: Tour, name: str, model: str, x: float, y: float, yaw: float) -> bool:
    house = tour.world.house
    try:
        house.add_object(name, model, x, y, float(wrap(yaw)))
    except HouseError:
        return False
    if _robot_is_free(tour):
        return True
    house.remove_object(name)
    return False


def _move(tour: Tour, thing: HouseObject, x: float, y: float, yaw: float) -> bool:
    house = tour.world.house
    try:
        house.move_object(thing.id, x, y, yaw)
    except HouseError:
        return False
    if _robot_is_free(tour):
        return True
    house.move_object(thing.id, thing.x, thing.y, thing.yaw, thing.on, None if thing.on else thing.elevation)
    return False


def _can_be_seen(tour: Tour, noun: str, rng) -> bool:
    """Whether such a thing is in view from one of ``LOOKS`` places, by lot, that ways lead to as wide as any home's."""
    world, space = tour.world, FreeSpace(tour.world.house)
    roomy = space.frame.to_world(*np.nonzero(space.clearance >= PASSAGE))
    start = roomy[np.argmin(np.hypot(*(roomy - world.truth[:2]).T))]
    places = space.frame.to_world(*np.nonzero(space.reachable(PASSAGE, start)))
    camera = world.config.camera_model
    for thing in instances_of(world.house, noun):
        sight = np.array([thing.x, thing.y]) - places
        away = np.hypot(*sight.T)
        near = np.flatnonzero((away >= camera.min_depth) & (away <= camera.max_depth))
        for i in rng.permutation(near)[:LOOKS]:
            pose = np.array([*places[i], np.arctan2(sight[i, 1], sight[i, 0])])
            if world.visible_fraction(thing.id, pose) >= VISIBLE_SHARE:
                return True
    return False


def _robot_is_free(tour: Tour) -> bool:
    return what_blocks(tour.world.house, tour.world.truth[:2], ROBOT_RADIUS) is None
