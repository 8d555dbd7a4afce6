from dataclasses import replace

import numpy as np
import pytest

from edge.localization.likelihood_field import LikelihoodField
from edge.localization.scan_matching import MatchConfig, _linearise, match, refine, scan_points, search, walls
from edge.mapping.occupancy import OccupancyGrid
from edge.observation import LaserScan
from edge.pose import compose, wrap

FAR = np.array([0.15, 0.15, np.radians(8)])


def places(tour, count, seed=1):
    rng = np.random.default_rng(seed)
    rows, cols = np.nonzero(tour.open)
    chosen = rng.choice(len(rows), count, replace=False)
    return np.column_stack([tour.frame.to_world(rows, cols)[chosen], rng.uniform(-np.pi, np.pi, count)]), rng


def error(found, truth):
    return float(np.hypot(*(found - truth)[:2])), float(abs(wrap(found[2] - truth[2])))


def test_recovers_offsets_of_15_cm_and_8_degrees(boxes_map, scan):
    grid, tour, lidar = boxes_map
    poses, rng = places(tour, 100)
    errors, scores, sigmas = [], [], []
    for pose in poses:
        guess = pose + rng.uniform(-FAR, FAR)
        found = match(LikelihoodField.around(grid, guess, 9.0), scan(lidar, pose), guess)
        errors.append(error(found.pose, pose))
        scores.append(found.score)
        sigmas.append(np.sqrt(np.diag(found.covariance)))
    distance, angle = np.array(errors).T
    assert distance.max() < 0.05 and np.sqrt((distance**2).mean()) < 0.02
    assert np.degrees(angle.max()) < 1.0 and min(scores) > 0.85
    # The stated covariance is honest: nobody is more than four deviations off, and it is not merely huge.
    assert (distance < 4 * np.hypot(*np.array(sigmas).T[:2])).all() and np.median(sigmas) < 0.02


def test_a_bad_guess_is_found_by_the_search(boxes_map, scan):
    grid, tour, lidar = boxes_map
    poses, rng = places(tour, 30, seed=2)
    config = MatchConfig()
    good = 0
    for pose in poses:
        guess = pose + np.array([0.28, -0.28, np.radians(-11)]) * rng.choice([-1, 1], 3)
        field, points = LikelihoodField.around(grid, guess, 9.0), scan_points(scan(lidar, pose), 0.1)
        coarse = search(field, points, guess, config.search_distance, config.search_angle, config)
        assert error(coarse, pose)[0] < 0.12 and error(coarse, pose)[1] < np.radians(3)
        good += error(match(field, scan(lidar, pose), guess).pose, pose)[0] < 0.05
    assert good >= 27


def test_search_agrees_with_trying_every_pose(boxes_map, scan):
    """The vectorised lattice search against one pose at a time."""
    grid, tour, lidar = boxes_map
    config = replace(MatchConfig(), search_points=10**6)
    pose = places(tour, 1, seed=5)[0][0]
    guess = pose + np.array([0.06, -0.08, 0.05])
    field, points = LikelihoodField.around(grid, guess, 9.0), scan_points(scan(lidar, pose), 0.1)

    def fit(candidate):
        cos, sin = np.cos(candidate[2]), np.sin(candidate[2])
        total = 0.0
        for x, y in points:
            where = np.array([candidate[0] + cos * x - sin * y, candidate[1] + sin * x + cos * y])
            row, col = field.frame.to_cell(where)
            if field.frame.contains(row, col):
                total += np.exp(-0.5 * (field.distance[row, col] / config.kernel) ** 2)
        return total

    steps = 0.05 * np.arange(-2, 3)
    turns = config.search_step * np.arange(-3, 4)
    lattice = [guess + (x, y, turn) for turn in turns for y in steps for x in steps]
    got = search(field, points, guess, 0.10, np.radians(3.01), config)
    assert fit(got) == pytest.approx(max(map(fit, lattice)), rel=1e-6)


def test_moved_furniture_is_outvoted(boxes_map, scan):
    grid, tour, lidar = boxes_map
    poses, rng = places(tour, 20, seed=3)
    for pose in poses:
        seen = scan(lidar, pose)
        ranges = seen.ranges.copy()
        ranges[40:130] = np.minimum(ranges[40:130], rng.uniform(0.4, 0.9))  # somebody stands in a quarter of the view
        guess = pose + rng.uniform(-FAR, FAR) / 2
        found = match(LikelihoodField.around(grid, guess, 9.0), replace(seen, ranges=ranges), guess)
        assert error(found.pose, pose)[0] < 0.05 and error(found.pose, pose)[1] < np.radians(1.5)
        assert found.score > 0.6


def test_along_a_corridor_the_covariance_is_wide():
    """Two parallel walls say nothing about x."""
    angles = -np.pi + np.arange(360) * 2 * np.pi / 360
    exact = np.abs(1.02 / np.where(np.abs(np.sin(angles)) < 0.2, np.nan, np.sin(angles)))
    rng = np.random.default_rng(0)

    def corridor():
        ranges = (exact + rng.normal(0, 0.01, 360)).astype(np.float32)
        return LaserScan(0.0, ranges, -np.pi, 2 * np.pi / 360, 8.0, np.zeros(3))

    grid = OccupancyGrid()
    for x in np.arange(-9, 9, 0.1):
        grid.integrate_scan(np.array([x, 0.0, 0.0]), corridor())
    guess = np.array([0.12, 0.06, 0.03])
    found = match(LikelihoodField.around(grid, guess, 8.0), corridor(), guess)
    sigma = np.sqrt(np.diag(found.covariance))
    assert sigma[0] > 10 * sigma[1] and sigma[1] < 0.01 and sigma[2] < 0.01
    assert abs(found.pose[0] - guess[0]) < 0.1 and abs(found.pose[1]) < 0.01


def test_wall_normals_are_numpys_smallest_principal_axes(boxes_map, scan):
    _, tour, lidar = boxes_map
    config = MatchConfig()
    points = scan_points(scan(lidar, places(tour, 1, seed=4)[0][0]), 0.1)
    normals = walls(points, config)
    found = np.flatnonzero(normals.any(axis=1))
    assert 0.4 < len(found) / len(points) < 0.98
    for i in found:
        window = points[np.arange(i - config.wall_beams, i + config.wall_beams + 1) % len(points)]
        values, vectors = np.linalg.eigh(np.cov(window.T))
        assert abs(vectors[:, 0] @ normals[i]) == pytest.approx(1.0, abs=1e-9)
        assert values[0] < config.wall_flatness * values[1]
        assert np.hypot(*np.diff(window, axis=0).T).max() <= config.wall_gap


def test_too_little_to_match_scores_nothing(boxes_map, scan):
    grid, tour, lidar = boxes_map
    pose = places(tour, 1)[0][0]
    seen = scan(lidar, pose)
    empty = match(LikelihoodField.around(OccupancyGrid(), pose, 8.0), seen, pose)
    field = LikelihoodField.around(grid, pose, 8.0)
    for nothing in (np.nan, np.inf, 0.0):
        blind = match(field, replace(seen, ranges=np.full(360, nothing, np.float32)), pose)
        assert blind.score == empty.score == 0.0 and (blind.pose == pose).all()
    elsewhere = pose + np.array([100.0, 0.0, 0.0])
    assert match(field, seen, elsewhere).score == 0.0


def test_a_scan_of_another_place_scores_badly(boxes_map, scan):
    grid, tour, lidar = boxes_map
    poses, _ = places(tour, 40, seed=7)
    wrong = [
        match(LikelihoodField.around(grid, b, 9.0), scan(lidar, a), b).score
        for a, b in zip(poses, poses[1:])
        if np.hypot(*(a - b)[:2]) > 2.0
    ]
    assert np.median(wrong) < 0.6


def test_the_jacobian_is_that_of_the_distances(boxes_map, scan):
    grid, tour, lidar = boxes_map
    pose = places(tour, 1, seed=9)[0][0]
    field, points = LikelihoodField.around(grid, pose, 9.0), scan_points(scan(lidar, pose), 0.1)
    free = np.zeros_like(points)
    value, jacobian, _ = _linearise(field, points, free, pose)
    step = 1e-8
    for axis in range(3):
        ahead = _linearise(field, points, free, pose + step * np.eye(3)[axis])[0]
        np.testing.assert_allclose(jacobian[:, axis], (ahead - value) / step, atol=2e-2)


def test_matching_does_not_depend_on_where_the_map_lies(boxes_map, scan):
    grid, tour, lidar = boxes_map
    pose = places(tour, 1, seed=11)[0][0]
    field, points = LikelihoodField.around(grid, pose, 9.0), scan_points(scan(lidar, pose), 0.1)
    moved = replace(field, frame=replace(field.frame, origin=tuple(np.add(field.frame.origin, (7.0, -3.0)))))
    a = refine(field, points, compose(pose, (0.05, 0.02, 0.03)), MatchConfig())
    b = refine(moved, points, compose(pose + [7.0, -3.0, 0.0], (0.05, 0.02, 0.03)), MatchConfig())
    np.testing.assert_allclose(b.pose - a.pose, [7.0, -3.0, 0.0], atol=1e-6)
