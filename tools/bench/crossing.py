"""Whether the robot gives way: ``python -m tools.bench.crossing`` drives it about while a person crosses its path.

Each run is driven twice from the same state and seed, between two random places of a home that the robot knows: first
alone, then with a person who walks, at constant speed and blind, straight across the way that the robot took, so that
they would meet if neither gave way. The person needs free floor of their own width; comes from 1.5 m and two seconds
or more to the side, at 60 to 120 degrees to the way; and ends 0.8 m or more beyond it. So there is room to wait.
Nothing is asked of what the robot can see: many come round a corner, or through a door.
"""

import sys
from dataclasses import dataclass

import numpy as np

from edge.missions.mission import Mission
from edge.missions.motion import drive
from edge.planning.theta_star import plan
from firmware_sim.base import Contact
from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.pedestrian import Pedestrian
from firmware_sim.placement import ROBOT_RADIUS
from firmware_sim.world import World
from tools.bench.options import homes_and_seeds
from tools.bench.survey import Sightless, robot_in, survey

LENGTH = 3.0, 8.0  # m of way between the two places
ROOM = 0.30  # m from all obstacles, of both places and of the middle of the person's way
SPEED = 0.5, 1.2  # m/s, of the person
MIDST = 1.0  # m of the robot's way, at least, before and after the crossing: it has been driving, and will
PACE = 0.4  # m/s, about what the robot drives on average
ANGLE = np.radians([60, 120])  # between the ways of person and robot
BEFORE, AFTER = (1.5, 4.0), (0.8, 2.5)  # m that the person walks to the crossing and beyond: at least, at most
NOTICE = 2.0  # s that the person walks before the crossing, at least
JITTER = 0.4  # s that the person is early or late, at most
ASIDE = 0.75  # m from the way, at least, where the person stands before and after: nobody blocks it
MOVING = 0.02  # m/s; slower, the robot stands
TIME_LIMIT = 90.0  # s a drive
TRIES = 200  # of each random choice, until it keeps all these rules


class NoCrossing(RuntimeError):
    """No place was found in this home where a person could cross the robot's way."""


class Drive(Mission):
    """From here to a place in the map."""

    def __init__(self, robot, goal):
        self.goal = goal
        super().__init__(robot)

    def story(self):
        return (yield from drive(self.robot, self.goal))


@dataclass(frozen=True)
class Driven:
    """One drive."""

    arrived: bool
    way: np.ndarray  # (T, 3) s, m, m: when the robot truly was where
    contacts: list[Contact]
    closest: float  # m between the surfaces of robot and person, inf without one
    error: float  # m, RMS of the robot's own pose

    @property
    def duration(self) -> float:
        """s"""
        return float(self.way[-1, 0])


def go(house: House, grid: bytes, start, goal, seed: int, pedestrian: Pedestrian | None = None) -> Driven:
    """Drive from ``start (3,)`` to ``goal (2,)`` in the house frame."""
    world = World(house, seed, start=start)
    if pedestrian is not None:
        world.admit(pedestrian)
    mission = Drive(robot_in(world, grid, Sightless()), goal)
    observation, way, errors, closest = world.step(None), [], [], np.inf
    while not mission.done and world.time < TIME_LIMIT:
        observation = world.step(mission.step(observation))
        here = world.truth[:2]
        way.append([world.time, *here])
        errors.append(np.hypot(*(mission.robot.in_map(observation.odom)[:2] - here)))
        if pedestrian is not None:
            gap = np.hypot(*(pedestrian.position(world.time) - here)) - pedestrian.radius - ROBOT_RADIUS
            closest = min(closest, float(gap))
    error = float(np.sqrt(np.mean(np.square(errors))))
    return Driven(mission.outcome is True, np.array(way), world.base.contacts, closest, error)


def places(space: FreeSpace, rng) -> tuple[np.ndarray, np.ndarray]:
    """A start ``(3,)`` and a goal ``(2,)`` with a way between them that can be crossed. Raises NoCrossing if none."""
    free = space.reachable(ROOM)
    rows, cols = np.nonzero(free)
    for _ in range(TRIES):
        start, goal = space.frame.to_world(rows, cols)[rng.integers(len(rows), size=2)]
        way = plan(free, space.frame, start, goal, space.clearance)
        if way is None or not LENGTH[0] <= (length := np.hypot(*np.diff(way, axis=0).T).sum()) <= LENGTH[1]:
            continue
        try:
            crossing(_paced(way, length / PACE), space, rng)
        except NoCrossing:
            continue
        return np.array([*start, rng.uniform(-np.pi, np.pi)]), goal
    raise NoCrossing("no two places have a way between them that somebody could cross")


def _paced(path: np.ndarray, duration: float) -> np.ndarray:
    """A path ``(K, 2)`` driven evenly in ``duration`` [s]: a way ``(T, 3)`` as ``crossing`` takes it."""
    reached = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    times = np.arange(0.0, duration, 0.1)
    driven = times / duration * reached[-1]
    return np.stack([times, *(np.interp(driven, reached, path[:, axis]) for axis in (0, 1))], axis=1)


def crossing(way: np.ndarray, space: FreeSpace, rng) -> Pedestrian:
    """A person who would meet the robot on its ``way (T, 3)``. Raises NoCrossing where nobody can cross it."""
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way[:, 1:], axis=0).T))])
    moments = np.flatnonzero((driven > MIDST) & (driven < driven[-1] - MIDST))
    for moment in rng.choice(moments, TRIES):
        time, place = way[moment, 0], way[moment, 1:]
        along = way[moment + 5, 1:] - way[moment - 5, 1:]
        angle = np.arctan2(along[1], along[0]) + rng.choice([-1, 1]) * rng.uniform(*ANGLE)
        direction = np.array([np.cos(angle), np.sin(angle)])
        before, after = (_room(space, place, side * direction) for side in (-1, 1))
        before, after = min(before, BEFORE[1]), min(after, AFTER[1])
        speed, late = rng.uniform(*SPEED), rng.uniform(-JITTER, JITTER)
        if before < max(BEFORE[0], NOTICE * speed) or after < AFTER[0]:
            continue
        ends = np.array([place - before * direction, place + after * direction])
        person = Pedestrian(ends, speed, departure=time + late - before / speed)
        gaps = np.hypot(*(person.position(way[:, 0]) - way[:, 1:]).T)
        aside = min(np.hypot(*(way[:, 1:] - end).T).min() for end in ends)
        if gaps.min() < person.radius + ROBOT_RADIUS and gaps[0] > ASIDE and aside > ASIDE:
            return person
    raise NoCrossing("nobody can cross the way")


def _room(space: FreeSpace, place, direction) -> float:
    """How far [m] a person may walk from ``place`` (2,)."""
    distance = np.arange(0.0, 5.0, space.frame.resolution)
    cells = space.frame.to_cell(place + distance[:, None] * direction)
    inside = space.frame.contains(*cells)
    clear = np.where(inside, space.clearance[tuple(np.where(inside, index, 0) for index in cells)], 0.0)
    return float(distance[np.argmax(clear < ROOM)])


def meet(house: House, grid: bytes, space: FreeSpace, seed: int) -> tuple[Driven, Driven]:
    """The drive alone and the same with a person. Raises NoCrossing when the home has no room for them."""
    rng = np.random.default_rng(seed)
    for _ in range(TRIES):
        start, goal = places(space, rng)
        alone = go(house, grid, start, goal, seed)
        if not alone.arrived:
            continue
        try:
            person = crossing(alone.way, space, rng)
        except NoCrossing:
            continue
        return alone, go(house, grid, start, goal, seed, person)
    raise NoCrossing(f"nobody can cross the robot's way in {house.name}")


def row(name: str, runs: list[tuple[Driven, Driven]]) -> str:
    """One line of the table."""
    met = [driven for _, driven in runs]
    contacts = [contact for driven in met for contact in driven.contacts]
    person = [contact for contact in contacts if contact.person]
    moving = sum(contact.speed > MOVING for contact in contacts)
    arrived = [(alone, driven) for alone, driven in runs if driven.arrived]
    extra = np.mean([driven.duration - alone.duration for alone, driven in arrived]) if arrived else np.nan
    errors = [np.sqrt(np.mean([driven.error**2 for driven in side])) for side in zip(*runs)]
    return (
        f"{name:12} {len(runs):5d} {len(person):8d} {len(contacts) - len(person):6d} {moving:7d} {len(arrived):8d} "
        f"{extra:9.1f} s {min(driven.closest for driven in met):8.2f} m {errors[0]:9.3f} {errors[1]:5.3f} m"
    )


def main() -> None:
    houses, seeds = homes_and_seeds("tools.bench.crossing", __doc__, 100, "in all homes together")
    maps = [(house, survey(house).to_bytes(), FreeSpace(house)) for house in houses]
    found: list[list] = [[] for _ in houses]
    for number, seed in enumerate(seeds):
        home = number % len(houses)
        try:
            found[home].append(meet(*maps[home], seed))
        except NoCrossing as error:
            print(f"tools.bench.crossing: {error}", file=sys.stderr)
            sys.exit(2)
    heads = "home", "runs", "person", "other", "moving", "arrivals", "longer by", "closest", "pose error"
    print("{:12} {:>5} {:>8} {:>6} {:>7} {:>8} {:>11} {:>10} {:>17}".format(*heads))
    for house, runs in zip(houses, found):
        if runs:
            print(row(house.name, runs))
    print(row("all", [run for runs in found for run in runs]))


if __name__ == "__main__":
    main()
