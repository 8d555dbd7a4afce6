"""A home of plain boxes, and a driver that tours a house by the truth, so that drift is measured without a mission."""

from types import SimpleNamespace

import numpy as np
import pytest

from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan, Twist
from edge.planning.theta_star import plan
from edge.pose import wrap
from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House
from firmware_sim.lidar import Lidar, LidarConfig


def box(name, width, depth, height):
    corners = np.array([[-width, -depth], [width, -depth], [width, depth], [-width, depth]]) / 2
    slices = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1) if height > 0.25 else np.zeros((0, 2, 2))
    size = (width, depth, height)
    return SimpleNamespace(
        id=name, name=name, category="Office", size=size, footprint=corners, slices=slices, top=height
    )


def wall(*ends):
    return {"a": list(ends[:2]), "b": list(ends[2:])}


def room(name, x0, y0, x1, y1):
    return {"name": name, "category": "Office", "polygon": [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]}


@pytest.fixture(scope="session")
def boxes_home():
    """Four rooms of 4 x 3.5 m around no corridor: hall, den, kitchen and bedroom in a ring of doors."""
    models = [box("sofa", 1.8, 0.8, 0.7), box("cupboard", 0.9, 0.5, 1.8), box("stool", 0.35, 0.35, 0.45)]
    things = [
        ("sofa", 1.2, 0.6, 0.0), ("cupboard", 3.5, 0.9, 1.57), ("stool", 2.4, 2.2, 0.4),
        ("sofa", 6.5, 3.0, 3.14), ("cupboard", 4.6, 1.2, 1.57), ("stool", 6.2, 1.0, 0.2),
        ("sofa", 0.6, 5.5, 1.57), ("cupboard", 3.2, 6.6, 0.0), ("stool", 2.2, 5.0, 0.9),
        ("sofa", 6.2, 6.4, 0.1), ("cupboard", 7.6, 4.6, 1.57), ("stool", 5.6, 4.6, 0.6),
    ]  # fmt: skip
    return House.from_dict(
        {
            "name": "boxes",
            "rooms": [
                room("hall", 0, 0, 4, 3.5),
                room("den", 4, 0, 8, 3.5),
                room("kitchen", 0, 3.5, 4, 7),
                room("bedroom", 4, 3.5, 8, 7),
            ],
            "walls": [
                wall(0, 0, 8, 0), wall(8, 0, 8, 7), wall(8, 7, 0, 7), wall(0, 7, 0, 0),
                wall(4, 0, 4, 1.8), wall(4, 2.7, 4, 5.2), wall(4, 6.1, 4, 7),
                wall(0, 3.5, 1.5, 3.5), wall(2.4, 3.5, 5.2, 3.5), wall(6.1, 3.5, 8, 3.5),
            ],
            "doors": [
                wall(4, 1.8, 4, 2.7), wall(4, 5.2, 4, 6.1), wall(1.5, 3.5, 2.4, 3.5), wall(5.2, 3.5, 6.1, 3.5),
            ],
            "objects": [
                {"id": f"{model}-{i}", "model": model, "position": [x, y], "yaw": yaw}
                for i, (model, x, y, yaw) in enumerate(things)
            ],
            "start": [2.8, 1.6, 0.5],
        },
        {model.id: model for model in models},
    )  # fmt: skip


class Tour:
    """Visits the middle of every room and comes back, following paths over the true plan with the true pose."""

    def __init__(self, house, radius=0.24):
        space = FreeSpace(house)
        self.frame, self.open = space.frame, space.reachable(radius)
        rows, cols = np.nonzero(self.open)
        places = self.frame.to_world(rows, cols)
        middles = [np.mean(room.polygon, axis=0) for room in house.rooms]
        self.goals = [places[np.hypot(*(places - middle).T).argmin()] for middle in middles]
        self.goals.append(np.array(house.start[:2], float))
        self.path = np.zeros((0, 2))

    def command(self, truth):
        """The twist that leads on from the true pose (3,), or None when the tour is over."""
        while len(self.path) == 0 or np.hypot(*(self.path[-1] - truth[:2])) < 0.12:
            if not self.goals:
                return None
            route = plan(self.open, self.frame, truth[:2], self.goals.pop(0))
            if route is None:
                continue
            steps = [np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / 0.05))) for a, b in zip(route, route[1:])]
            self.path = np.concatenate(steps) if steps else route
        near = np.hypot(*(self.path - truth[:2]).T)
        self.path = self.path[near.argmin() :]
        ahead = self.path[min(6, len(self.path) - 1)] - truth[:2]
        error = float(wrap(np.arctan2(ahead[1], ahead[0]) - truth[2]))
        return Twist(0.5 * max(0.0, 1.0 - abs(error)), float(np.clip(2.5 * error, -1.2, 1.2)))


def mapped(house, seed=0):
    """Grid made at true poses all over the house, in the house frame, with a noisy lidar: a map without drift."""
    rng = np.random.default_rng(seed)
    lidar, grid, tour = Lidar(house, LidarConfig(), rng), OccupancyGrid(), Tour(house)
    rows, cols = np.nonzero(tour.open)
    for place in tour.frame.to_world(rows, cols)[:: len(rows) // 60]:
        pose = np.array([*place, rng.uniform(-np.pi, np.pi)])
        grid.integrate_scan(pose, scan_at(lidar, pose))
    return grid, tour, lidar


def scan_at(lidar, pose, odom=None):
    config = lidar.config
    odom = np.asarray(pose if odom is None else odom, float)
    return LaserScan(0.0, lidar.scan(pose), config.angle_min, config.angle_increment, config.range_max, odom)


@pytest.fixture(scope="session")
def tour():
    return Tour


@pytest.fixture(scope="session")
def boxes_map(boxes_home):
    """Grid, tour and lidar of the boxes home."""
    return mapped(boxes_home)


@pytest.fixture(scope="session")
def scan():
    return scan_at
