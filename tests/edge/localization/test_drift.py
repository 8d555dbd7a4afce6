"""Mapping and localization of a robot without eyes over a tour of each home, sensor noise on, judged by the truth."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg
from edge.pose import between, transform, wrap
from edge.robot import Robot
from firmware_sim.base import BaseConfig
from firmware_sim.house import House
from firmware_sim.lidar import Lidar, LidarConfig
from firmware_sim.world import World, WorldConfig
from tools.bench.survey import Sightless


@dataclass
class Drive:
    errors: np.ndarray  # (T, 3) m, m, rad: pose in the map against the truth
    odometry: np.ndarray  # (T, 3) the same without localization
    grid: OccupancyGrid
    surfaces: np.ndarray  # (N, 2) m, noise-free lidar hits from the true poses, in the map frame
    rejected: int


def drive(house, tour, seed=0, base=None):
    """Tours the house; the first odometry is the map's origin, so the truth is taken relative to the start."""
    world = World(house, seed, WorldConfig(camera=False, base=base or BaseConfig()))
    robot, guide = Robot(Sightless(), Vlpg.open(":memory:", "none", "none", 1)), tour(house)
    exact = Lidar(house, LidarConfig(noise=0.0), None)
    angles = np.arange(360) * exact.config.angle_increment + exact.config.angle_min
    errors, odometry, surfaces, rejected = [], [], [], 0
    twist = guide.command(world.truth)
    while twist is not None:
        assert world.time < 600, "the tour does not end"
        seen = world.step(twist)
        robot.perceive(seen)
        truth = between(house.start, world.truth)
        errors.append(robot.pose - truth)
        odometry.append(seen.odom - truth)
        rejected += robot.localizer.lost
        if len(errors) % 5 == 0:
            ranges = exact.scan(world.truth)
            hit = np.isfinite(ranges)
            beams = ranges[hit, None] * np.stack([np.cos(angles[hit]), np.sin(angles[hit])], axis=-1)
            surfaces.append(transform(truth, beams))
        twist = guide.command(world.truth)
    errors, odometry = np.array(errors), np.array(odometry)
    errors[:, 2], odometry[:, 2] = wrap(errors[:, 2]), wrap(odometry[:, 2])
    return Drive(errors, odometry, robot.grid, np.concatenate(surfaces), rejected)


def rms(errors):
    """Position [m] and heading [deg]."""
    return np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean()), np.degrees(np.sqrt((errors[:, 2] ** 2).mean()))


@pytest.fixture(scope="module", params=["boxes", "apartment", "cottage", "bungalow"])
def driven(request, boxes_home, tour):
    house = boxes_home if request.param == "boxes" else House.load(request.param)
    return SimpleNamespace(name=request.param, **vars(drive(house, tour)))


def test_drift_over_a_tour(driven):
    distance, angle = rms(driven.errors)
    alone = rms(driven.odometry)
    print(f"{driven.name}: RMS drift {distance:.3f} m {angle:.2f} deg; odometry {alone[0]:.3f} m {alone[1]:.2f} deg")
    assert distance <= 0.10 and angle <= 3.0
    assert np.hypot(*driven.errors[:, :2].T).max() < 0.15
    assert driven.rejected == 0


def test_the_map_is_the_home(driven):
    """Precision: mapped obstacles lie on true surfaces. Recall: true surfaces that were measured often are mapped."""
    rows, cols = np.nonzero(driven.grid.lidar > 0)
    mapped = driven.grid.frame.to_world(rows, cols)
    off = cKDTree(driven.surfaces).query(mapped)[0]
    cells, counts = np.unique(np.floor(driven.surfaces / 0.05), axis=0, return_counts=True)
    missed = cKDTree(mapped).query((cells[counts >= 5] + 0.5) * 0.05)[0]
    precision, recall = (off <= 0.10).mean(), (missed <= 0.10).mean()
    print(f"{driven.name}: precision {precision:.3f} recall {recall:.3f}, {len(mapped)} cells")
    assert precision > 0.97 and recall > 0.97


def test_bad_odometry_is_made_up_for(boxes_home, tour):
    """Wheels five times as uneven and slippery as they should be."""
    got = drive(boxes_home, tour, seed=3, base=BaseConfig(scale_error=0.02, slip=0.10))
    distance, angle = rms(got.errors)
    assert rms(got.odometry)[0] > distance
    assert distance <= 0.10 and angle <= 3.0
