"""A robot that knows its home from the first step: its map was made from true poses all over the floor."""

import numpy as np

from edge.localization.localizer import Localizer
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg
from edge.observation import LaserScan
from edge.perception.encoder import View
from edge.robot import Robot
from firmware_sim.camera import Camera
from firmware_sim.free_space import FreeSpace
from firmware_sim.lidar import Lidar, LidarConfig
from firmware_sim.world import World

PLACES = 60  # that the home is seen from, of its whole floor; a tour maps some 2 000
TURNS = 4  # pictures at each, in a circle
RADIUS = 0.24  # m from every obstacle: where the robot may stand


class Sightless:
    """An encoder to which all pictures look the same, for robots that need not recognize anything."""

    name, digest, dim = "sightless", "0" * 64, 8

    def encode_image(self, rgb, hfov, window=None) -> View:
        return View(np.eye(4, self.dim, dtype=np.float32), np.zeros(4), (), window)


def survey(house, seed: int = 0) -> OccupancyGrid:
    """The map, in the house frame, that noisy lidar and camera make from true poses: a map without drift."""
    rng = np.random.default_rng(seed)
    grid, space = OccupancyGrid(), FreeSpace(house)
    lidar, camera = Lidar(house, LidarConfig(), rng), Camera(house, seed=seed)
    config = lidar.config
    rows, cols = np.nonzero(space.reachable(RADIUS))
    for place in space.frame.to_world(rows, cols)[:: max(1, len(rows) // PLACES)]:
        for heading in np.linspace(-np.pi, np.pi, TURNS, endpoint=False):
            pose = np.array([*place, heading])
            ranges = lidar.scan(pose)
            grid.integrate_scan(
                pose, LaserScan(0.0, ranges, config.angle_min, config.angle_increment, config.range_max, pose)
            )
            grid.integrate_depth(pose, camera.render(pose).depth, camera.model)
    return grid


def robot_in(world: World, grid: bytes, encoder) -> Robot:
    """A robot that has the map ``grid`` in the house frame, and knows where in it the ``world`` has put it."""
    robot = Robot(encoder, Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim), world.config.camera_model)
    robot.grid = OccupancyGrid.from_bytes(grid)
    robot.localizer = Localizer(world.truth)
    robot.pose = world.truth
    return robot
