"""The grid from rendered pictures of a furnished home, at true poses, judged by the true floor plan."""

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.occupancy import OccupancyGrid
from edge.pose import transform
from firmware_sim.camera import Camera
from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House


@pytest.fixture(scope="module", params=["apartment", "cottage", "bungalow"])
def looked_around(request):
    """House and depth-only grid after a full turn at eight places far apart."""
    house = House.load(request.param)
    model = CameraModel()
    camera, grid = Camera(house, model, 0), OccupancyGrid()
    space = FreeSpace(house)
    rows, cols = np.nonzero(space.reachable(0.3))
    places = space.frame.to_world(rows, cols)
    chosen = [np.array(house.start[:2])]
    for _ in range(7):
        chosen.append(places[np.min([np.hypot(*(places - place).T) for place in chosen], axis=0).argmax()])
    for place in chosen:
        for heading in np.arange(0, 2 * np.pi, np.radians(30)):
            pose = np.array([*place, heading])
            grid.integrate_depth(pose, camera.render(pose).depth, model)
    return house, grid, space


def true_clearance(grid, space):
    row, col = space.frame.to_cell(grid.frame.to_world(*np.indices(grid.frame.shape)))
    inside = space.frame.contains(row, col)
    clearance = np.zeros(grid.frame.shape)
    clearance[inside] = space.clearance[row[inside], col[inside]]
    return clearance


def test_obstacles_are_where_the_plan_has_them_and_open_floor_is_free(looked_around):
    _, grid, space = looked_around
    clearance = true_clearance(grid, space)
    precision = (clearance[grid.occupied] <= 0.10).mean()
    known = (clearance > 0.15) & ~grid.unknown
    print(f"precision {precision:.3f}; open floor free {grid.free[known].mean():.4f} of {known.sum()} known cells")
    assert precision > 0.97
    assert grid.free[known].mean() > 0.985


def test_furniture_of_the_robots_height_is_seen(looked_around):
    """Of the footprints in clear view, nearly all hold a mapped obstacle; outlines exceed the things."""
    house, grid, _ = looked_around
    seen, found = 0, 0
    for thing in house.objects.values():
        low, high = thing.height_range
        if thing.on is not None or low > 0.0 or high < 0.2:
            continue
        middle, outline = thing.footprint.mean(axis=0), thing.footprint
        points = np.concatenate([middle + share * (outline - middle) for share in (0.0, 0.3, 0.6, 0.9)])
        row, col = grid.frame.to_cell(points)
        inside = grid.frame.contains(row, col)
        row, col = row[inside], col[inside]
        if not len(row) or grid.unknown[row, col].mean() > 0.5:
            continue
        seen += 1
        found += grid.occupied[row, col].any()
    print(f"{found} of {seen} things mapped")
    assert seen >= 10 and found >= seen - 1


def test_what_is_in_the_pictures_agrees_with_the_lidars_view(looked_around):
    """A camera-only map and the house's wall faces: the faces in view are occupied."""
    house, grid, space = looked_around
    faces = house.wall_segments()
    share = np.linspace(0.05, 0.95, 40)[:, None]
    points = np.concatenate([a + share * (b - a) for a, b in faces if np.hypot(*(b - a)) > 0.5])
    near = np.stack([transform((x, y, 0.0), points) for x in (-0.05, 0.0, 0.05) for y in (-0.05, 0.0, 0.05)])
    row, col = grid.frame.to_cell(near)
    inside = grid.frame.contains(row, col).all(axis=0)
    row, col = row[:, inside], col[:, inside]
    known = (~grid.unknown[row, col]).any(axis=0)
    recall = grid.occupied[row, col].any(axis=0)[known].mean()
    print(f"{known.mean():.2f} of the wall faces seen, {recall:.3f} of these mapped")
    assert known.mean() > 0.5 and recall > 0.9
