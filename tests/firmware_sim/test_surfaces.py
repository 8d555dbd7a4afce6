import numpy as np
import pytest

from edge.camera import CameraModel
from firmware_sim.surfaces import CEILING, Surfaces, floor_pattern


@pytest.fixture
def camera_model():
    return CameraModel()


def expected_depth(model, x, y, heading):
    """Depth of the walls, floor and ceiling of one room 0.05 < x < 3.95, 0.05 < y < 3.95, 2.5 m high, by geometry."""
    u, v = np.meshgrid(np.arange(model.width), np.arange(model.height))
    left, up = (model.centre[0] - u) / model.focal, (model.centre[1] - v) / model.focal
    dx = np.cos(heading) - np.sin(heading) * left
    dy = np.sin(heading) + np.cos(heading) * left
    with np.errstate(divide="ignore"):
        to_x = np.where(dx > 0, 3.95 - x, 0.05 - x) / dx
        to_y = np.where(dy > 0, 3.95 - y, 0.05 - y) / dy
        to_z = np.where(up > 0, 2.5 - model.mount_height, -model.mount_height) / up
    return np.minimum(np.minimum(to_x, to_y), to_z)


@pytest.mark.parametrize("pose", [(2.0, 2.0, 2.4), (0.6, 3.2, -2.0), (3.0, 0.9, -1.2), (1.0, 1.0, -3.0)])
def test_depth_is_that_of_geometry(empty, camera_model, pose):
    _, depth = Surfaces(empty, camera_model).draw(*pose)
    expected = expected_depth(camera_model, *pose)
    through_door = depth > expected + 0.2  # the doorway at x = 4 is open
    assert through_door.mean() < 0.3
    np.testing.assert_allclose(depth[~through_door], expected[~through_door], atol=0.25)
    close = np.abs(depth - expected)[~through_door]
    assert np.quantile(close, 0.99) < 1e-4  # but for the door frame, which is 0.1 m thick


def test_one_sees_through_an_open_door_and_not_through_a_closed_one(plan, boxes, camera_model):
    from firmware_sim.house import House

    middle = camera_model.height // 2, camera_model.width // 2
    assert Surfaces(House.from_dict(plan, boxes), camera_model).draw(2.0, 2.0, 0.0)[1][middle] == pytest.approx(4.95)
    plan["doors"][0]["open"] = False
    assert Surfaces(House.from_dict(plan, boxes), camera_model).draw(2.0, 2.0, 0.0)[1][middle] == pytest.approx(1.95)


def test_walls_have_their_rooms_colour(plan, boxes, camera_model):
    from firmware_sim.house import House

    plan["rooms"][0]["wall_color"], plan["rooms"][1]["wall_color"] = [200, 60, 60], [60, 60, 200]
    rgb, _ = Surfaces(House.from_dict(plan, boxes), camera_model).draw(2.0, 2.0, 0.0)
    red_wall, blue_wall = rgb[90:110, 20:60].mean((0, 1)), rgb[90:110, 155:165].mean((0, 1))
    assert red_wall[0] > 2 * red_wall[2]
    assert blue_wall[2] > 2 * blue_wall[0]


@pytest.mark.parametrize("pose", [(2.0, 2.0, 0.0), (3.6, 0.4, 1.3), (4.5, 3.6, -1.7), (5.5, 1.5, 2.9)])
def test_the_floor_is_where_its_map_says(plan, boxes, camera_model, pose):
    """A carpet west of x = 4 and light tiles east of it, seen from anywhere: each pixel shows what lies there."""
    from firmware_sim.house import House

    plan["rooms"][0]["floor"], plan["rooms"][1]["floor"] = "carpet", "tiles"
    plan["walls"] = plan["walls"][:4]  # none between the rooms
    plan["doors"] = []
    rgb, depth = Surfaces(House.from_dict(plan, boxes), camera_model).draw(*pose)
    u, v = np.meshgrid(np.arange(camera_model.width), np.arange(140, camera_model.height))
    z = camera_model.focal * camera_model.mount_height / (v - camera_model.centre[1])
    left = (camera_model.centre[0] - u) / camera_model.focal * z
    x = pose[0] + np.cos(pose[2]) * z - np.sin(pose[2]) * left
    floor = np.abs(depth[140:] - z) < 1e-3
    light = rgb[140:].mean(2)
    west, east = light[floor & (x < 3.85)], light[floor & (x > 4.15)]
    assert min(len(west), len(east)) > 1000
    assert np.quantile(west, 0.98) < 170 < np.quantile(east, 0.15)
    line = floor & (z < 2.5) & (np.abs(x - 4) > 0.015) & (np.abs(x - 4) < 0.05)  # nearby, the border is sharp
    assert line.sum() > 100
    assert ((light > 170) == (x > 4))[line].mean() > 0.9


def test_the_ceiling_is_light(empty, camera_model):
    rgb, _ = Surfaces(empty, camera_model).draw(0.5, 2.0, 0.0)
    assert np.abs(rgb[0, 160].astype(int) - CEILING).max() < 40


@pytest.mark.parametrize("kind", ["wood", "tiles", "carpet", "stone"])
def test_floors_differ_and_are_not_flat(kind):
    pattern = floor_pattern(kind, (120, 150), np.random.default_rng(0))
    assert pattern.shape == (120, 150, 3)
    assert pattern.std() > 3


def test_a_picture_with_a_row_exactly_at_the_horizon(empty):
    rgb, depth = Surfaces(empty, CameraModel(width=65, height=49)).draw(2.0, 2.0, np.pi)
    assert depth[24, 32] == pytest.approx(1.95)
    assert rgb.shape == (49, 65, 3)
