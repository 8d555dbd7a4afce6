"""Held-out evaluation in the simulated homes: do the views that show an object rank first when it is asked for?"""

from dataclasses import dataclass

import numpy as np

from firmware_sim.camera import Camera
from firmware_sim.free_space import FreeSpace
from firmware_sim.generator import generate

VIEWS = 120  # a home
SHARE = 0.004  # of the picture's pixels: an object smaller than this (17 x 17 px) is not "truly shown"
VISIBLE = 0.4  # of its unoccluded silhouette


@dataclass(frozen=True)
class Shot:
    """A picture and which objects of the home it truly shows."""

    rgb: np.ndarray  # (H, W, 3) uint8
    instances: np.ndarray  # (H, W) index of the object, -1 = none
    shown: np.ndarray  # (objects,) bool


def shoot(seed: int, views: int = VIEWS) -> tuple[list[str], list[Shot]]:
    """Names of the objects of home ``seed``, and pictures from random free poses in it."""
    house = generate(seed)
    camera = Camera(house, seed=seed)
    rng = np.random.default_rng(seed)
    names = [house.objects[i].model.name for i in camera.object_ids]
    poses = _free_poses(house, rng, views)
    shots = []
    for pose in poses:
        picture = camera.render(pose)
        pixels = np.bincount(picture.instances[picture.instances >= 0].ravel(), minlength=len(names))
        shown = pixels > SHARE * picture.instances.size
        for k in np.flatnonzero(shown):
            whole = camera.silhouette(pose, camera.object_ids[k]).sum()
            shown[k] = pixels[k] >= VISIBLE * whole
        shots.append(Shot(picture.rgb, picture.instances, shown))
    return names, shots


def _free_poses(house, rng: np.random.Generator, count: int) -> np.ndarray:
    """Poses (count, 3) with random heading, anywhere a robot of 0.18 m radius can come to."""
    space = FreeSpace(house)
    rows, cols = np.nonzero(space.reachable(0.2))
    chosen = rng.integers(len(rows), size=count)
    points = space.frame.to_world(rows[chosen], cols[chosen])
    return np.column_stack([points, rng.uniform(-np.pi, np.pi, count)])
