"""Does the robot know where it is? ``python -m tools.bench.place`` wakes it up in homes it knows, and pushes it.

Waking up: at random places, with one turn of the lidar and the map, and nothing else. Pushed: before a drive between
two random places it is up to 0.3 m and 10 degrees away from where it believes to be, and its wheels do not tell.
"""

import time
from dataclasses import dataclass

import numpy as np

from edge.localization.localizer import Localizer
from edge.mapping.occupancy import OccupancyGrid
from edge.pose import compose, wrap
from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.world import World
from tools.bench.crossing import TIME_LIMIT, Drive, places
from tools.bench.options import homes_and_seeds
from tools.bench.survey import Sightless, robot_in, survey

ROOM = 0.30  # m from all obstacles, where it wakes up
PUSH = 0.3, np.radians(10)  # m, rad; at most
RIGHT = 0.2, 0.1  # m, rad; nearer to the truth, it has found its place


@dataclass(frozen=True)
class Woken:
    """What a robot that woke up somewhere made of it."""

    found: bool
    right: bool
    seconds: float


def wake(house: House, grid: OccupancyGrid, space: FreeSpace, seed: int) -> Woken:
    """Wake up at a random place of a home whose map is ``grid``."""
    rng = np.random.default_rng(seed)
    rows, cols = np.nonzero(space.reachable(ROOM))
    place = rng.integers(len(rows))
    start = np.array([*space.frame.to_world(rows[place], cols[place]), rng.uniform(-np.pi, np.pi)])
    world = World(house, seed, start=start)
    seen = world.step(None)
    while seen.scan is None:
        seen = world.step(None)
    localizer, began = Localizer(lost=True), time.perf_counter()
    found = localizer.relocalize(seen.scan, grid)
    seconds = time.perf_counter() - began
    x, y, turned = localizer.pose(seen.odom) - world.truth
    right = np.hypot(x, y) < RIGHT[0] and abs(wrap(turned)) < RIGHT[1]
    return Woken(found, found and bool(right), seconds)


def pushed(house: House, grid: bytes, space: FreeSpace, seed: int) -> tuple[bool, float]:
    """Push, then drive: whether it arrived, and how far [m] it then was from where it believed to be."""
    rng = np.random.default_rng(seed)
    start, goal = places(space, rng)
    world = World(house, seed, start=start)
    mission = Drive(robot_in(world, grid, Sightless()), goal)
    robot, seen = mission.robot, world.step(None)
    distance, direction = PUSH[0] * np.sqrt(rng.uniform()), rng.uniform(-np.pi, np.pi)
    push = [distance * np.cos(direction), distance * np.sin(direction), rng.uniform(-1, 1) * PUSH[1]]
    robot.localizer.move(robot.pose, compose(robot.pose, np.array(push)))
    while not mission.done and world.time < TIME_LIMIT:
        seen = world.step(mission.step(seen))
    error = np.hypot(*(robot.in_map(seen.odom)[:2] - world.truth[:2]))
    return mission.outcome is True, float(error)


def main() -> None:
    houses, seeds = homes_and_seeds("tools.bench.place", __doc__, 20, "of each kind in each home")
    heads = "woken", "found", "wrong", "took", "pushed", "arrived", "error: median, max"
    print("{:12} {:>6} {:>6} {:>6} {:>7}   {:>6} {:>8} {:>19}".format("", *heads))
    for house in houses:
        grid, space = survey(house), FreeSpace(house)
        woken = [wake(house, grid, space, seed) for seed in seeds]
        drives = [pushed(house, grid.to_bytes(), space, seed) for seed in seeds]
        arrived, errors = zip(*drives)
        found, wrong = sum(one.found for one in woken), sum(one.found and not one.right for one in woken)
        took = np.median([one.seconds for one in woken])
        print(
            f"{house.name:12} {len(woken):6} {found:6} {wrong:6} {took:5.2f} s   {len(drives):6} {sum(arrived):8} "
            f"{np.median(errors):9.3f} {max(errors):7.3f} m",
            flush=True,
        )


if __name__ == "__main__":
    main()
