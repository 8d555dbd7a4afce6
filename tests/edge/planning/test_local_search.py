"""The probability map against Eq. 7 by hand, and the search against a hidden object."""

from dataclasses import replace
from random import Random

import cv2
import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.planning.local_search import LocalSearch, LocalSearchConfig
from tests.edge.planning.fields import field_of_view

CAMERA = CameraModel()
PAPER = LocalSearchConfig(size=6.0, elsewhere=0.9)
FRAME = GridFrame((-6.0, -4.0), 0.05, (160, 240))  # 12 x 8 m
VIEWS = np.array([[-1.5, 0.0, 0.0], [-1.4, 0.3, -0.2]])


@pytest.fixture
def home():
    """A room with a table and a screen that hides a corner; returns occupied, free, reachable and clearance."""
    occupied = np.zeros(FRAME.shape, bool)
    occupied[[20, 139]] = occupied[:, [60, 179]] = True
    occupied[70:90, 120:140] = True  # table
    occupied[100:139, 110:112] = True  # screen
    clearance = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, 5) * 0.05
    free = ~occupied
    inside = np.zeros_like(free)
    inside[21:139, 61:179] = True
    return occupied, free & inside, inside & (clearance > 0.25), clearance


def search_in(home, views=VIEWS, p_star=0.6, config=PAPER, centre=(0.0, 0.0)):
    occupied, free, _, _ = home
    return LocalSearch(occupied, free, FRAME, centre, views, p_star, CAMERA, config)


def window_of(grid, search):
    row, col = FRAME.to_cell(np.array(search.frame.origin) + 1e-6)
    rows, cols = search.frame.shape
    return grid[row : row + rows, col : col + cols]


def test_map_follows_equation_7_with_surfaces(home):
    occupied, free, _, _ = home
    search = search_in(home, p_star=[0.6, 0.5])
    assert search.probability.shape == (120, 120)
    absent = np.full(FRAME.shape, 0.9)
    fields = [field_of_view(occupied, FRAME, pose, CAMERA) for pose in VIEWS]
    for field, p in zip(fields, (0.6, 0.5)):
        absent[field] *= 1 - p
    for row, col in np.argwhere(occupied):
        if not free[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2].any():
            absent[row, col] = 1.0
    difference = np.abs(search.probability - window_of(1 - absent, search))
    border = np.ones((120, 120), bool)
    border[1:-1, 1:-1] = False  # free cells outside the window are not known there
    assert difference[~border].max() < 1e-6
    table = window_of(occupied, search) & (search.probability > 0)
    assert search.probability[table].max() > 0.5  # the near side of the table is a place to look at
    assert search.probability[60, 70] == 0.0  # its middle is not


def test_window_reaches_beyond_the_grid(home):
    search = search_in(home, centre=(5.5, -3.5))
    assert search.probability.shape == (120, 120)
    assert np.isfinite(search.probability).all()


def test_observed_leaves_a_fifth_in_view_and_nothing_else_changes(home):
    search = search_in(home)
    before = search.probability.copy()
    pose = np.array([1.0, -1.0, 2.0])
    search.observed(pose)
    view = field_of_view(window_of(home[0], search), search.frame, pose, CAMERA)
    np.testing.assert_allclose(search.probability[view], 0.2 * before[view], rtol=1e-6)
    np.testing.assert_array_equal(search.probability[~view], before[~view])


def test_next_pose_is_reachable_inside_the_map_and_deterministic(home):
    occupied, free, reachable, clearance = home
    poses = [search_in(home).next_pose(VIEWS[0], reachable, clearance, FRAME, Random(4)) for _ in range(2)]
    np.testing.assert_array_equal(*poses)
    assert reachable[FRAME.to_cell(poses[0][:2])]
    assert np.abs(poses[0][:2]).max() <= 3.0


def test_sees_much_of_what_could_be_seen_from_anywhere(home):
    """The chosen view against the best of a dense brute-force set of poses."""
    _, _, reachable, clearance = home
    config = replace(PAPER, distance_weight=0.0, obstacle_weight=0.0)
    search = search_in(home, config=config)
    window = window_of(home[0], search)

    def seen(pose):
        return search.probability[field_of_view(window, search.frame, pose, CAMERA)].sum()

    rows, cols = np.nonzero(reachable)
    places = FRAME.to_world(rows, cols)[::97]
    best = max(seen((*xy, heading)) for xy in places for heading in np.arange(0, 6.28, 0.7))
    pose = search.next_pose(VIEWS[0], reachable, clearance, FRAME, Random(0))
    assert seen(pose) > 0.6 * best


def test_what_came_to_stand_in_the_way_hides_nothing_of_what_was_remembered(home):
    occupied, *_ = home
    search = search_in(home, p_star=0.95)
    screened = occupied.copy()
    screened[60:100, 100:103] = True  # a metre before the first viewpoint
    before = search.probability.copy()
    search.notice(screened, FRAME)
    np.testing.assert_array_equal(search.probability, before)
    behind = tuple(int(i) for i in search.frame.to_cell(np.array([-0.4, 0.6])))
    assert before[behind] > 0.9
    search.observed(VIEWS[0])
    assert search.probability[behind] == before[behind]


def test_the_grid_may_grow_while_it_is_searched(home):
    occupied, free, _, _ = home
    search, same = search_in(home), search_in(home)
    grown = GridFrame((FRAME.origin[0] - 1.0, FRAME.origin[1] - 2.0), FRAME.resolution, (240, 300))
    search.notice(grown.holding(occupied, FRAME, False), grown)
    pose = np.array([1.0, -1.0, 2.0])
    search.observed(pose)
    same.observed(pose)
    np.testing.assert_array_equal(search.probability, same.probability)


def test_finds_what_a_screen_hides_within_the_limit_of_replans(home):
    occupied, _, reachable, clearance = home
    hidden = FRAME.to_cell(np.array([-0.1, 2.2]))  # behind the screen
    found = 0
    for seed in range(20):
        search, rng, pose = search_in(home, config=LocalSearchConfig()), Random(seed), VIEWS[0]
        assert not field_of_view(occupied, FRAME, pose, CAMERA)[hidden]
        search.observed(pose)
        while (pose := search.next_pose(pose, reachable, clearance, FRAME, rng)) is not None:
            if field_of_view(occupied, FRAME, pose, CAMERA)[hidden]:
                found += 1
                break
            search.observed(pose)
        assert search.replans <= LocalSearchConfig.replans
    assert found >= 12  # 44 of seeds 0 to 59


def test_prefers_near_views_when_the_way_counts(home):
    _, _, reachable, clearance = home
    robot = np.array([-2.0, -2.0, 0.0])

    def way(weight):
        config = LocalSearchConfig(distance_weight=weight)
        searches = [search_in(home, config=config) for _ in range(5)]
        poses = [s.next_pose(robot, reachable, clearance, FRAME, Random(seed)) for seed, s in enumerate(searches)]
        return np.hypot(*(np.array(poses) - robot)[:, :2].T).mean()

    assert way(5.0) < way(0.0)


def test_gives_up(home):
    _, _, reachable, clearance = home
    rng = Random(0)
    search = search_in(home)
    assert search.next_pose(VIEWS[0], np.zeros_like(reachable), clearance, FRAME, rng) is None
    search = search_in(home, config=LocalSearchConfig(replans=2))
    views = [search.next_pose(VIEWS[0], reachable, clearance, FRAME, rng) for _ in range(3)]
    assert views[0] is not None and views[1] is not None and views[2] is None
    search = search_in(home)
    search.probability[:] = 0
    assert search.next_pose(VIEWS[0], reachable, clearance, FRAME, rng) is None
    assert (
        search_in(home, config=LocalSearchConfig(worthwhile=1.1)).next_pose(VIEWS[0], reachable, clearance, FRAME, rng)
        is None
    )
