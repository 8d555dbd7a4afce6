"""What the camera shows is checked against projections of footprint and height, not against the code that renders."""

import cv2
import numpy as np
import pytest

from edge.camera import CameraModel
from edge.pose import between, compose, transform
from firmware_sim.camera import Camera, CameraNoise
from firmware_sim.furniture import Furniture
from firmware_sim.house import House

MODEL = CameraModel()
BOXES = ["bedside-table2", "large-fridge", "speaker3", "wardrobe-with-sliding-doors", "crate"]  # fill their footprint
FURNITURE = Furniture.load()


@pytest.fixture
def hall(plan):
    """Makes a house of one hall, -1 < x < 6 m and -3 < y < 3 m, of things (id, model, x, y, yaw[, on])."""

    def make(*things):
        plan["rooms"] = [{"name": "hall", "category": "Office", "polygon": [[-1, -3], [6, -3], [6, 3], [-1, 3]]}]
        corners = [[-1, -3], [6, -3], [6, 3], [-1, 3]]
        plan["walls"] = [{"a": a, "b": b} for a, b in zip(corners, corners[1:] + corners[:1])]
        plan["doors"], plan["start"] = [], [0.0, 0.0, 0.0]
        plan["objects"] = [
            {"id": i, "model": m, "position": [float(x), float(y)], "yaw": float(yaw), "on": on[0] if on else None}
            for i, m, x, y, yaw, *on in things
        ]
        return House.from_dict(plan, FURNITURE)

    return make


def prism(thing, pose):
    """Corners (2 N, 3) in base_link of the footprint, extruded from the bottom to the top of the thing."""
    flat = transform(between(pose, thing.pose), thing.model.footprint)
    low, high = thing.elevation, thing.elevation + thing.model.size[2]
    return np.concatenate([np.insert(flat, 2, z, axis=1) for z in (low, high)])


def projected(points):
    """Pixels (H, W) bool whose centres lie in the convex hull of the projections of points in base_link."""
    u, v, depth = MODEL.project(points)
    assert (depth > 0).all()
    hull = cv2.convexHull(np.stack([u, v], 1).astype(np.float32)).reshape(-1, 2).astype(float)
    rows, columns = np.mgrid[: MODEL.height, : MODEL.width]
    sides = [
        (b[0] - a[0]) * (rows - a[1]) - (b[1] - a[1]) * (columns - a[0]) for a, b in zip(hull, np.roll(hull, -1, 0))
    ]
    return (np.array(sides) >= 0).all(0) | (np.array(sides) <= 0).all(0)


def views(count, seed):
    """Distances [m], bearings [rad] and headings [rad] of things before the camera."""
    rng = np.random.default_rng(seed)
    return zip(rng.uniform(1.3, 4.0, count), rng.uniform(-0.5, 0.5, count), rng.uniform(-np.pi, np.pi, count))


@pytest.mark.parametrize("name", BOXES)
def test_silhouette_of_a_box_is_its_projected_footprint_and_height(hall, name):
    overlaps, borders = [], []
    for distance, bearing, yaw in views(6, seed=3):
        house = hall(("it", name, distance * np.cos(bearing), distance * np.sin(bearing), yaw))
        pose = np.zeros(3)
        seen, expected = Camera(house, noise=False).silhouette(pose, "it"), projected(prism(house.objects["it"], pose))
        if expected.sum() < 200:
            continue
        overlaps.append((seen & expected).sum() / (seen | expected).sum())
        for axis in (0, 1):
            a, b = np.flatnonzero(seen.any(axis)), np.flatnonzero(expected.any(axis))
            borders += [abs(a[0] - b[0]), abs(a[-1] - b[-1])]
    assert min(overlaps) > 0.84 and np.mean(overlaps) > 0.94
    assert np.quantile(borders, 0.9) <= 3 and np.mean(borders) < 1.2


@pytest.mark.parametrize("name", ["teddy-bear", "oak-chair", "winchester-sofa", "toilets-unit", "bed1", "piano-bench"])
def test_no_silhouette_leaves_its_projected_bounding_box(hall, name):
    for distance, bearing, yaw in views(4, seed=5):
        distance += 0.6
        house = hall(("it", name, distance * np.cos(bearing), distance * np.sin(bearing), yaw))
        pose = np.zeros(3)
        seen = Camera(house, noise=False).silhouette(pose, "it")
        width, depth, height = house.objects["it"].model.size
        corners = np.array([[x, y] for x in (-width, width) for y in (-depth, depth)]) / 2
        flat = transform(house.objects["it"].pose, corners)
        box = projected(np.concatenate([np.insert(flat, 2, z, axis=1) for z in (0, height)]))
        roomy = cv2.dilate(box.view(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
        assert not (seen & ~roomy).any()
        assert seen.sum() > 0.15 * box.sum()


@pytest.mark.parametrize("name", BOXES)
def test_depth_of_a_box_is_the_distance_of_its_footprint(hall, name):
    for distance, bearing, yaw in views(6, seed=8):
        house = hall(("it", name, distance * np.cos(bearing), distance * np.sin(bearing), yaw))
        picture = Camera(house, noise=False).render(np.zeros(3))
        thing = house.objects["it"]
        hull = transform(thing.pose, thing.model.footprint)
        errors = []
        for u in np.flatnonzero((picture.instances == 0).any(0))[3:-3:4]:
            depth = nearest_crossing(hull, (MODEL.ahead, 0.0), (MODEL.centre[0] - u) / MODEL.focal)
            rows = np.arange(MODEL.height)
            height = MODEL.mount_height + (MODEL.centre[1] - rows) / MODEL.focal * depth
            side = (height > 0.15) & (height < thing.model.size[2] - 0.1) & (picture.instances[:, u] == 0)
            errors.extend(picture.depth[side & (picture.depth[:, u] > 0), u] - depth)
        if len(errors) > 50:
            assert np.median(np.abs(errors)) < 0.035, (distance, bearing, yaw)
            assert np.quantile(np.abs(errors), 0.9) < 0.12, (distance, bearing, yaw)


def nearest_crossing(polygon, origin, slope):
    """Depth t at which the ray origin + t (1, slope) first meets the polygon."""
    a, b = polygon - origin, np.roll(polygon, -1, 0) - origin
    side_a, side_b = a[:, 1] - slope * a[:, 0], b[:, 1] - slope * b[:, 0]
    crossing = side_a * side_b < 0
    share = side_a[crossing] / (side_a - side_b)[crossing]
    depths = a[crossing, 0] + share * (b - a)[crossing, 0]
    return depths.min() if len(depths) else np.nan


def test_a_thing_on_a_table_stands_on_it(hall):
    house = hall(("table", "lb-desk", 2.5, 0, 0), ("bear", "teddy-bear", 2.5, 0, -np.pi / 2, "table"))
    camera = Camera(house, noise=False)
    rows = np.flatnonzero(camera.silhouette(np.zeros(3), "bear").any(1))
    _, v, _ = MODEL.project([[2.5 - 0.1, 0, 0.72], [2.5, 0, 0.72 + 0.322]])
    assert rows[-1] == pytest.approx(v[0], abs=3)
    assert rows[0] == pytest.approx(v[1], abs=3)


def test_the_nearer_thing_hides_the_farther_one(hall):
    house = hall(("far", "refrigerator", 3.5, 0, -np.pi / 2), ("near", "drawers-cabinet", 2, 0, -np.pi / 2))
    camera = Camera(house, noise=False)
    picture = camera.render(np.zeros(3))
    far, near = camera.object_ids.index("far"), camera.object_ids.index("near")
    hidden = camera.silhouette(np.zeros(3), "near")
    assert (picture.instances[hidden] == near).mean() > 0.995
    whole = camera.silhouette(np.zeros(3), "far")
    assert ((picture.instances == far) == (whole & ~hidden)).mean() > 0.999
    assert picture.depth[picture.instances == near].max() < picture.depth[picture.instances == far].min() + 0.7


def test_colour_depth_and_instances_are_registered(hall):
    """A red sofa before a light wall: the same pixels are red, near, and the sofa's."""
    picture = Camera(hall(("sofa", "winchester-sofa", 3, 0.3, -np.pi / 2)), noise=False).render(np.zeros(3))
    red = picture.rgb[..., 0].astype(int) > 2 * picture.rgb[..., 1].astype(int)
    sofa = picture.instances == 0
    assert (red & sofa).sum() / (red | sofa).sum() > 0.93
    assert 2.3 < picture.depth[sofa].min() < picture.depth[sofa].max() < 3.8
    assert np.median(picture.depth[~sofa & (np.arange(MODEL.height)[:, None] > 80)]) != np.median(picture.depth[sofa])


def test_walls_hide_what_is_behind_them(plan):
    plan["objects"] = [{"id": "it", "model": "refrigerator", "position": [6.0, 3.3], "yaw": 0.0}]
    camera = Camera(House.from_dict(plan, FURNITURE), noise=False)
    pose = np.array([1.0, 3.3, 0.0])
    assert not (camera.render(pose).instances >= 0).any()
    assert camera.silhouette(pose, "it").sum() > 300


def test_a_door_that_closes_hides_the_next_room(plan):
    house = House.from_dict(plan, FURNITURE)
    camera, pose = Camera(house, noise=False), np.array([3.0, 2.0, 0.0])
    column = int(MODEL.centre[0])
    assert camera.render(pose).depth[120, column] == pytest.approx(3.85, abs=0.02)
    house.set_door(0, open=False)
    assert camera.render(pose).depth[120, column] == pytest.approx(0.85, abs=0.02)


def test_what_is_behind_the_camera_is_not_seen(hall):
    camera = Camera(hall(("it", "refrigerator", -0.4, -2.4, 0)), noise=False)
    assert not camera.silhouette(np.zeros(3), "it").any()
    assert (camera.render(np.zeros(3)).instances == -1).all()


def test_moved_added_and_removed_things_are_noticed(hall):
    house = hall(("bear", "teddy-bear", 2.0, 0.5, 0))
    camera = Camera(house, noise=False)
    left = np.nonzero(camera.render(np.zeros(3)).instances == 0)[1].mean()
    house.move_object("bear", 2.0, -0.5)
    right = np.nonzero(camera.render(np.zeros(3)).instances == 0)[1].mean()
    assert left < MODEL.centre[0] - 20 < MODEL.centre[0] + 20 < right
    house.add_object("ball", "basketball", 2.5, 0.5)
    instances = camera.render(np.zeros(3)).instances
    assert camera.object_ids == ["bear", "ball"]
    assert (instances == 1).any()
    house.remove_object("bear")
    assert set(np.unique(camera.render(np.zeros(3)).instances)) == {-1, 1}


def test_depth_noise_grows_with_the_square_of_the_distance(hall):
    spread = {}
    for distance in (1.5, 3.0, 4.5):
        pose = np.array([5.95 - MODEL.ahead - distance, 0.0, 0.0])
        patch = Camera(hall(), seed=4).render(pose).depth[100:140, 100:220]
        spread[distance] = patch[patch > 0].std()
        assert np.median(patch[patch > 0]) == pytest.approx(distance, abs=0.01)
    for distance, value in spread.items():
        assert value == pytest.approx(CameraNoise().disparity * distance**2, rel=0.25)


def test_beyond_its_range_the_camera_measures_nothing(hall):
    depth = Camera(hall(), seed=1).render(np.array([5.6, 0.0, 0.0])).depth
    assert (depth[120] == 0).all()  # the wall is 0.25 m off
    depth = Camera(hall(), seed=1).render(np.array([-0.5, 0.0, 0.0])).depth
    assert (depth[115:125, 155:165] == 0).all()  # 6.4 m
    assert depth[depth > 0].min() >= MODEL.min_depth and depth.max() <= MODEL.max_depth


def test_pictures_repeat_from_the_same_seed(hall):
    def take(seed):
        camera = Camera(hall(("it", "teddy-bear", 1.5, 0, 0)), seed=seed)
        return [camera.render(np.array([0.1 * i, 0, 0.2 * i])) for i in range(3)]

    for a, b in zip(take(7), take(7)):
        assert np.array_equal(a.rgb, b.rgb) and np.array_equal(a.depth, b.depth)
    assert not np.array_equal(take(7)[0].depth, take(8)[0].depth)


def test_closest_approach_stays_finite(hall):
    """The robot touches a table: part of it is beside and behind the camera."""
    camera = Camera(hall(("it", "table", 2.0, 0.0, 0.0)), seed=0)
    for theta in np.linspace(-np.pi, np.pi, 24):
        picture = camera.render(compose((2.0, -0.7, 0.0), (0, 0, theta)))
        assert np.isfinite(picture.depth).all()
        assert picture.depth.max() <= MODEL.max_depth
