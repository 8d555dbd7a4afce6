"""How many times faster than real time the simulated house runs: ``python -m tools.bench.world``."""

import argparse
import time

from edge.observation import Twist
from firmware_sim.house import House
from firmware_sim.world import World, WorldConfig


def speed(house: House, camera: bool, seconds: float) -> float:
    """Simulated seconds a second of processor time, while the robot turns and drives to and fro.

    Processor time, so that other programs do not count; with a free core it is real time. What is read from disk once,
    the sprites, is read before in a turn on the spot.
    """
    world = World(house, 0, WorldConfig(camera=camera))
    for _ in range(80):
        world.step(Twist(0.0, 1.0))
    steps = round(seconds / 0.1)
    begin = time.process_time()
    for i in range(steps):
        world.step(Twist(0.2 if i % 40 < 20 else -0.2, 0.6))
    return steps * 0.1 / (time.process_time() - begin)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("homes", nargs="*", default=["apartment", "cottage", "bungalow"], help="names or JSON files")
    parser.add_argument("--seconds", type=float, default=30.0, help="simulated seconds a measurement")
    options = parser.parse_args()
    print(f"{'home':12} {'objects':>7} {'camera + lidar':>15} {'lidar only':>11}   (times real time)")
    for name in options.homes:
        house = House.load(name)
        rates = [speed(house, camera, options.seconds) for camera in (True, False)]
        print(f"{house.name:12} {len(house.objects):7d} {rates[0]:14.1f}x {rates[1]:10.1f}x")


if __name__ == "__main__":
    main()
