"""Fields of view against brute-force geometry, and the ranking on hand-made hits."""

from math import cos, hypot, pi, sin, tan

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.planning.viewpoint import ViewpointConfig, rank_viewpoints, visible_cells
from tests.edge.planning.fields import field_of_view

CAMERA = CameraModel()
FRAME = GridFrame((-4.0, -3.0), 0.05, (160, 200))


def optical_centre(pose):
    return pose[0] + CAMERA.ahead * cos(pose[2]), pose[1] + CAMERA.ahead * sin(pose[2])


def sector(pose, margin):
    """Cells whose centre lies in the field of view in free space, shrunk (margin > 0) or grown [m]."""
    cells = FRAME.to_world(*np.indices(FRAME.shape))
    x, y = optical_centre(pose)
    dx, dy = cells[..., 0] - x, cells[..., 1] - y
    ahead, left = dx * cos(pose[2]) + dy * sin(pose[2]), -dx * sin(pose[2]) + dy * cos(pose[2])
    distance = np.hypot(ahead, left)
    side = cos(CAMERA.hfov / 2) * (ahead * tan(CAMERA.hfov / 2) - np.abs(left))  # m inside the edge ray
    return (side > margin) & (distance > CAMERA.min_depth + margin) & (distance < CAMERA.max_depth - margin)


@pytest.mark.parametrize("pose", [(0, 0, 0.0), (0.012, -0.51, 0.7), (-2.0, 1.0, -2.5), (4.5, 3.9, -2.2), (1, 1, pi)])
def test_free_space_is_the_whole_sector(pose):
    mask = field_of_view(np.zeros(FRAME.shape, bool), FRAME, pose, CAMERA)
    assert mask[sector(pose, 0.075)].all()
    assert not mask[~sector(pose, -0.075)].any()


@pytest.mark.parametrize("seed", range(6))
def test_obstacles_hide_what_is_behind_them(seed):
    """Each cell against samples on the line from the camera to it, five millimetres apart."""
    rng = np.random.default_rng(seed)
    occupied = np.zeros(FRAME.shape, bool)
    for _ in range(25):
        row, col = rng.integers(0, 150), rng.integers(0, 190)
        occupied[row : row + rng.integers(2, 12), col : col + rng.integers(2, 12)] = True
    pose = np.array([0.3, 0.2, rng.uniform(-pi, pi)])
    x, y = optical_centre(pose)
    row, col = FRAME.to_cell(np.array([x, y]))
    occupied[row - 12 : row + 13, col - 12 : col + 13] = False
    mask = field_of_view(occupied, FRAME, pose, CAMERA)
    certain = wrong = 0
    for row, col in np.argwhere(sector(pose, 0.075))[::5]:
        target = FRAME.to_world(row, col)
        line = np.linspace((x, y), target, 2 + int(200 * hypot(*(target - (x, y)))))
        across = 0.03 * np.array([-(target - (x, y))[1], (target - (x, y))[0]]) / hypot(*(target - (x, y)))
        blocked = []
        for shift in (-across, 0 * across, across):
            rows, cols = FRAME.to_cell(line + shift)
            here = (np.abs(rows - row) <= 1) & (np.abs(cols - col) <= 1)
            blocked.append(bool((occupied[rows, cols] & ~here).any()))
        if all(blocked) or not any(blocked):  # elsewhere the edge of an obstacle passes through the cell
            certain += 1
            wrong += mask[row, col] != (not blocked[0])
    assert certain > 300
    assert wrong <= 0.01 * certain


def test_thin_diagonal_wall_is_closed_and_its_cells_are_seen():
    occupied = np.zeros(FRAME.shape, bool)
    steps = np.arange(-60, 60)
    occupied[60 + steps, 120 - steps] = True  # cells touch at corners only
    pose = (0.0, 0.0, 0.0)
    mask = field_of_view(occupied, FRAME, pose, CAMERA)
    rows, cols = np.indices(FRAME.shape)
    assert not mask[rows + cols > 180].any()
    assert mask[occupied].any() and mask[(rows + cols == 179)].any()


def test_outside_the_grid_is_not_seen():
    cells = visible_cells(np.zeros(FRAME.shape, bool), FRAME, (50.0, 50.0, 0.0), CAMERA)
    assert cells.size == 0


def around(x, y, theta, count, rng, spread=0.15):
    return np.column_stack([rng.normal((x, y), spread, (count, 2)), rng.normal(theta, 0.1, count)])


def test_clusters_separate_by_place_and_by_heading():
    rng = np.random.default_rng(0)
    poses = np.concatenate([around(0, 0, 0, 8, rng), around(0, 0, pi, 6, rng), around(3, 2, 0, 5, rng), [[-3, -2, 1]]])
    scores = np.full(20, 0.5)
    free = np.zeros(FRAME.shape, bool)
    ranked = rank_viewpoints(poses, scores, free, FRAME, CAMERA)
    assert [sorted(v.members) for v in ranked] == [list(range(8)), list(range(8, 14)), list(range(14, 19)), [19]]
    assert all(any(np.array_equal(v.pose, poses[i]) for i in v.members) for v in ranked)
    assert [v.support for v in ranked] == pytest.approx([8, 6, 5, 1])


def test_many_weak_hits_do_not_beat_a_few_strong_ones_unless_asked():
    rng = np.random.default_rng(1)
    poses = np.concatenate([around(0, 0, 0, 30, rng), around(3, 2, 0, 4, rng)])
    scores = np.concatenate([np.full(30, 0.3), np.full(4, 0.9)])
    free = np.zeros(FRAME.shape, bool)
    assert len(rank_viewpoints(poses, scores, free, FRAME, CAMERA)[0].members) == 4
    by_size = rank_viewpoints(poses, scores, free, FRAME, CAMERA, ViewpointConfig(ranking="size"))
    assert len(by_size[0].members) == 30


def test_equal_sizes_rank_by_mean_score():
    rng = np.random.default_rng(2)
    poses = np.concatenate([around(0, 0, 0, 5, rng), around(3, 2, 0, 5, rng)])
    scores = np.concatenate([np.full(5, 0.4), np.full(5, 0.5)])
    ranked = rank_viewpoints(poses, scores, np.zeros(FRAME.shape, bool), FRAME, CAMERA, ViewpointConfig(ranking="size"))
    assert ranked[0].score == pytest.approx(0.5)


def test_best_viewpoint_equals_brute_force_of_equation_3():
    rng = np.random.default_rng(3)
    occupied = np.zeros(FRAME.shape, bool)
    occupied[:, 140:142] = True
    poses = around(1.0, 0, 0.1, 7, rng, 0.4)
    poses[0, 2] = pi  # sees more than the others, but alone
    fields = [field_of_view(occupied, FRAME, pose, CAMERA) for pose in poses]
    overlaps = [(fields[i] & np.any([fields[j] for j in range(7) if j != i], axis=0)).sum() for i in range(7)]
    assert np.argmax([field.sum() for field in fields]) == 0 != np.argmax(overlaps)
    config = ViewpointConfig(cluster_radius=5.0)
    best = rank_viewpoints(poses, np.linspace(0.6, 0.5, 7), occupied, FRAME, CAMERA, config)
    assert len(best) == 1
    np.testing.assert_array_equal(best[0].pose, poses[int(np.argmax(overlaps))])


def test_weak_hits_have_no_say_in_where_to_look_from():
    rng = np.random.default_rng(2)
    poses = np.concatenate([around(0, 0, 0.6, 3, rng, 0.05), around(0, 0, 0.0, 20, rng, 0.05)])
    scores = np.concatenate([np.full(3, 0.9), np.full(20, 0.4)])
    free = np.zeros(FRAME.shape, bool)
    (best, *_) = rank_viewpoints(poses, scores, free, FRAME, CAMERA)
    assert len(best.members) == 23 and any(np.array_equal(best.pose, pose) for pose in poses[:3])
    (asked, *_) = rank_viewpoints(poses, scores, free, FRAME, CAMERA, ViewpointConfig(strong=1.0))
    assert any(np.array_equal(asked.pose, pose) for pose in poses[3:])


def test_no_hits_no_viewpoints():
    assert rank_viewpoints(np.empty((0, 3)), np.empty(0), np.zeros(FRAME.shape, bool), FRAME, CAMERA) == []
