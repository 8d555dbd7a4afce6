"""How many times faster than real time the simulated house runs: ``python -m tools.bench.world``."""

import argparse
import time
from statistics import median

from edge.observation import Twist
from firmware_sim.house import House
from firmware_sim.world import World, WorldConfig
from tools.bench.options import HANDMADE, load_homes

RUNS = 3


def speed(house: House, camera: bool, seconds: float) -> tuple[float, float]:
    """Simulated seconds a second, by the wall clock and by processor time, while the robot turns and drives to and fro.

    What is read from disk once, the sprites, is read before in a turn on the spot.
    """
    world = World(house, 0, WorldConfig(camera=camera))
    for _ in range(80):
        world.step(Twist(0.0, 1.0))
    steps = round(seconds / 0.1)
    begin, busy = time.perf_counter(), time.process_time()
    for i in range(steps):
        world.step(Twist(0.2 if i % 40 < 20 else -0.2, 0.6))
    return steps * 0.1 / (time.perf_counter() - begin), steps * 0.1 / (time.process_time() - busy)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tools.bench.world", description=__doc__)
    parser.add_argument("homes", nargs="*", default=HANDMADE, help="names, files or generated:SEED")
    parser.add_argument("--seconds", type=float, default=30.0, help="simulated seconds a measurement")
    options = parser.parse_args()
    houses = load_homes(parser, options.homes)
    print(f"{'home':12} {'objects':>7} {'camera + lidar':>26} {'lidar only':>26}")
    print("times real time: median (range) of three by the wall clock, [median by processor time]")
    for house in houses:
        rates = [[speed(house, camera, options.seconds) for _ in range(RUNS)] for camera in (True, False)]
        print(f"{house.name:12} {len(house.objects):7d} {_show(rates[0]):>26} {_show(rates[1]):>26}", flush=True)


def _show(rates: list[tuple[float, float]]) -> str:
    """Median and range by the wall clock, median by processor time."""
    wall, busy = zip(*rates)
    return f"{median(wall):.1f} ({min(wall):.1f}-{max(wall):.1f}) [{median(busy):.1f}]"


if __name__ == "__main__":
    main()
