"""Camera, lidar and physics are three views of one house: what one measures, the others must confirm."""

import cv2
import numpy as np
import pytest

from edge.camera import CameraModel
from firmware_sim.camera import Camera
from firmware_sim.house import House
from firmware_sim.lidar import Lidar, LidarConfig

MODEL, LIDAR = CameraModel(), LidarConfig()


def free_poses(house, count, seed):
    """Poses in rooms, at least 0.35 m from every wall and every footprint's corner circle."""
    rng = np.random.default_rng(seed)
    low, high = house.bounds
    poses = []
    while len(poses) < count:
        x, y = rng.uniform(low, high)
        if house.room_at(x, y) is None:
            continue
        gaps = [np.hypot(t.x - x, t.y - y) - np.hypot(*t.model.size[:2]) / 2 for t in house.objects.values()]
        a, b = np.moveaxis(house.wall_segments(), 1, 0)
        along = b - a
        share = np.clip((((x, y) - a) * along).sum(1) / (along**2).sum(1), 0, 1)
        wall = np.linalg.norm(a + share[:, None] * along - (x, y), axis=1).min()
        if min(gaps) > 0.2 and wall > 0.35:
            poses.append(np.array([x, y, rng.uniform(-np.pi, np.pi)]))
    return poses


@pytest.mark.parametrize("home", ["apartment", "cottage", "bungalow"])
def test_lidar_hits_lie_on_the_depth_image(home):
    """Each beam's hit, projected into the picture, has the depth seen there, or something nearer hides it."""
    house = House.load(home)
    camera, lidar = Camera(house, noise=False), Lidar(house, LIDAR, None)
    angles = LIDAR.angle_min + np.arange(LIDAR.beams) * LIDAR.angle_increment
    excess = []
    for pose in free_poses(house, 25, seed=2):
        ranges = lidar.scan(pose)
        hits = np.stack([ranges * np.cos(angles), ranges * np.sin(angles), np.full(len(angles), LIDAR.height)], 1)
        hits = hits[np.isfinite(ranges)]
        u, v, z = MODEL.project(hits)
        seen = (z > 0.5) & (z < 4.8) & (u > 2) & (u < MODEL.width - 3) & (v > 2) & (v < MODEL.height - 3)
        depth = camera.render(pose).depth
        columns, rows = u[seen].round().astype(int), v[seen].round().astype(int)
        known = depth[rows, columns] > 0
        excess.append((depth[rows, columns] - z[seen])[known])
    excess = np.concatenate(excess)
    assert len(excess) > 500
    assert (np.abs(excess) < 0.06).mean() > 0.8  # most are seen by both
    assert (excess > 0.12).mean() < 0.03  # where the lidar hits, the camera must not see through


@pytest.mark.parametrize("home", ["apartment", "cottage", "bungalow"])
def test_nothing_in_the_picture_is_before_the_nearest_footprint(home):
    """Points seen up to the robot's height, from the floor up, lie within the footprint of the thing that they show."""
    house = House.load(home)
    camera = Camera(house, noise=False)
    inside = []
    for pose in free_poses(house, 8, seed=5):
        picture = camera.render(pose)
        v, u = np.nonzero((picture.instances >= 0) & (picture.depth > 0))
        points = MODEL.unproject(u, v, picture.depth[v, u])
        keep = points[:, 2] < 0.95
        points, number = points[keep][::7], picture.instances[v, u][keep][::7]
        c, s = np.cos(pose[2]), np.sin(pose[2])
        xy = points[:, :2] @ np.array([[c, s], [-s, c]]) + pose[:2]
        for place, index in zip(xy.astype(np.float32), number):
            thing = house.objects[camera.object_ids[index]]
            if thing.elevation < 0.9:
                hull = thing.footprint.astype(np.float32).reshape(-1, 1, 2)
                inside.append(cv2.pointPolygonTest(hull, place.tolist(), True))
    inside = np.array(inside)
    assert len(inside) > 500
    assert (inside > -0.05).mean() > 0.98
