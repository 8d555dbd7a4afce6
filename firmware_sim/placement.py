"""The rules by which things stand in a house, and the sentences that say which one is broken."""

import numpy as np

from firmware_sim.polygons import contains, distance_to_segments, edges, penetration

ROBOT_RADIUS = 0.18  # m
ROBOT_HEIGHT = 1.0  # m; what hangs higher is no obstacle
STEP_HEIGHT = 0.03  # m; the wheels roll over what is lower
SLACK = 0.03  # m that footprints may overlap: they are convex hulls, the things are not
WALL_SLACK = 0.01  # m that a footprint may reach into the plaster


class HouseError(ValueError):
    """The house, or a change to it, is impossible; the message is one sentence for people."""


def is_obstacle(thing) -> bool:
    """Whether the robot's body can run into the object: not carried by another, not out of its height."""
    low, high = thing.height_range
    return thing.on is None and low < ROBOT_HEIGHT and high > STEP_HEIGHT


def check_house(house) -> None:
    """Raises HouseError on the first rule that the house breaks."""
    for thing in house.objects.values():
        check_object(house, thing)
    x, y, _ = house.start
    if house.room_at(x, y) is None:
        raise HouseError(f"the start ({x:.2f}, {y:.2f}) lies outside every room")
    blocker = what_blocks(house, house.start[:2], ROBOT_RADIUS)
    if blocker is not None:
        raise HouseError(f"the start ({x:.2f}, {y:.2f}) is blocked by {blocker}")


def check_object(house, thing) -> None:
    """Raises HouseError when the object is in a wall, in another object, outside every room or off its support."""
    where = f"object '{thing.id}' at ({thing.x:.2f}, {thing.y:.2f})"
    if house.room_at(thing.x, thing.y) is None:
        raise HouseError(f"{where} is outside every room")
    if house.plan.wall_overlap(thing.footprint) > WALL_SLACK:
        raise HouseError(f"{where} is inside a wall")
    if thing.on is not None and not contains(house.objects[thing.on].footprint, np.array([thing.x, thing.y])):
        raise HouseError(f"{where} is not above '{thing.on}', on which it should stand")
    low, high = thing.height_range
    if high > house.wall_height + SLACK:
        raise HouseError(f"{where} reaches {high:.2f} m, through the ceiling at {house.wall_height:.2f} m")
    reach = _reach(thing)
    for other in house.objects.values():
        other_low, other_high = other.height_range
        if other.id == thing.id or thing.on == other.id or other.on == thing.id:
            continue
        if low >= other_high - 1e-6 or other_low >= high - 1e-6:
            continue
        if abs(other.x - thing.x) + abs(other.y - thing.y) > reach + _reach(other):
            continue
        overlap = penetration(thing.footprint, other.footprint)
        if overlap > SLACK:
            raise HouseError(f"{where} overlaps '{other.id}' by {overlap:.2f} m")


def what_blocks(house, point, radius) -> str | None:
    """Name of a thing or wall within ``radius`` [m] of a point ``(2,)``, in the robot's way; None when it is free."""
    for thing in house.objects.values():
        if is_obstacle(thing):
            near = contains(thing.footprint, point) or distance_to_segments(point, edges(thing.footprint)) < radius
            if near:
                return f"object '{thing.id}'"
    inside = any(contains(body, point) for body in house.plan.wall_bodies)
    if inside or distance_to_segments(point, house.wall_segments()) < radius:
        return "a wall"
    return None


def _reach(thing) -> float:
    """Radius [m], in the sum norm, around the object's position that holds its footprint."""
    return float(np.abs(thing.footprint - (thing.x, thing.y)).sum(axis=1).max())
