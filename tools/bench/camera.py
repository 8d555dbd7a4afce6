"""Speed of the simulated RGB-D camera on one core: `python -m tools.bench.camera [HOME ...]`."""

import argparse
import time

import cv2
import numpy as np

from firmware_sim.camera import Camera
from firmware_sim.house import House
from tools.bench.options import HANDMADE, load_homes

FRAMES = 300
BLOCK = 20  # frames; the fastest block is what the code can do when nothing else runs
CLEAR = 0.3  # m between the camera and the footprint's circle of any thing


def poses(house: House, count: int, seed: int = 0) -> list[np.ndarray]:
    """Poses (3,) all over the rooms of a house, in all directions, clear of its furniture."""
    rng = np.random.default_rng(seed)
    low, high = house.bounds
    found = []
    while len(found) < count:
        x, y = rng.uniform(low, high)
        gaps = (np.hypot(t.x - x, t.y - y) - max(t.model.size[:2]) / 2 for t in house.objects.values())
        if house.room_at(x, y) is not None and min(gaps, default=np.inf) > CLEAR:
            found.append(np.array([x, y, rng.uniform(-np.pi, np.pi)]))
    return found


def measure(house: House) -> str:
    """One line on a home."""
    camera = Camera(house)
    places = poses(house, FRAMES)
    things = [np.unique(camera.render(pose).instances).size - 1 for pose in places]  # decodes the sprites on the way
    blocks, cpu = [], time.process_time()
    for start in range(0, FRAMES, BLOCK):
        begin = time.perf_counter()
        for pose in places[start : start + BLOCK]:
            camera.render(pose)
        blocks.append(BLOCK / (time.perf_counter() - begin))
    cpu = (time.process_time() - cpu) / FRAMES
    return (
        f"{house.name:12s} {len(house.objects):3d} things, {np.mean(things):.1f} in view: "
        f"{np.median(blocks):.0f} frames/s (fastest block {max(blocks):.0f}), "
        f"{1e3 * cpu:.1f} ms of CPU a frame = {1 / cpu:.0f} frames/s a core"
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tools.bench.camera", description=__doc__)
    parser.add_argument("homes", nargs="*", default=HANDMADE, help="names, files or generated:SEED")
    cv2.setNumThreads(1)
    for house in load_homes(parser, parser.parse_args().homes):
        print(measure(house))


if __name__ == "__main__":
    main()
