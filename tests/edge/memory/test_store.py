"""Views, edges and answers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.memory.store import VlpgConfig
from edge.pose import between
from tests.edge.memory.stores import COVARIANCE, DIM, opened, unit, walk


def test_a_view_is_found_again_with_its_region():
    store, rng = opened(), np.random.default_rng(0)
    views = walk(store, rng, 50)
    hits = store.search(views[17][2], 3)
    assert hits.ids[0] == 17 and hits.bearings[0] == pytest.approx(np.linspace(-0.4, 0.4, 4)[2])
    assert hits.scores[0] == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(store.poses(hits.ids[:1]), [[17, 0.5, 1.7]])


def test_the_gate_refuses_and_recent_knowledge_wins():
    store, rng = opened(config=VlpgConfig()), np.random.default_rng(1)
    before, after = unit(rng, 2)
    assert store.add(0.0, (0, 0, 0), COVARIANCE, before, [0.0]) == 0
    assert store.add(0.1, (0.05, 0, 0), COVARIANCE, before, [0.0]) is None
    assert not store.knows((0.05, 0, 0), before)  # there, a region might contradict it
    assert store.knows((0.3, 0, 0), before) and not store.knows((0.3, 0, 0), after)
    assert len(store) == 1
    assert store.add(9.0, (0.05, 0, 0.02), COVARIANCE, after, [0.0]) == 1
    assert store.ids.tolist() == [1]
    assert store.search(before, 5).ids.tolist() == [1]
    assert store.superseded_by(0) == 1 and store.superseded_by(1) is None
    np.testing.assert_allclose(store.poses([0]), [[0, 0, 0]])  # kept for audit


def test_consecutive_nodes_are_linked_and_loops_can_be_closed():
    store = opened()
    walk(store, np.random.default_rng(2), 4, regions=1)
    store.link(3, 0, (0.1, 0.2, 0.3), np.diag([1.0, 2.0, 3.0]))
    edges = store.edges()
    assert list(zip(edges.i.tolist(), edges.j.tolist(), edges.kinds, strict=True)) == [
        (0, 1, "odometry"),
        (1, 2, "odometry"),
        (2, 3, "odometry"),
        (3, 0, "loop"),
    ]
    np.testing.assert_allclose(edges.transforms[1], between(store.poses(1)[0], store.poses(2)[0]))
    np.testing.assert_allclose(edges.information[3], np.diag([1.0, 2.0, 3.0]))
    assert (np.linalg.eigvalsh(edges.information) > 0).all()


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), steps=st.integers(0, 60), data=st.data())
def test_reopened_equals_in_memory(tmp_path_factory, seed, steps, data):
    rng, path = np.random.default_rng(seed), tmp_path_factory.mktemp("store") / "home.vlpg"
    with opened(path) as store:
        walk(store, rng, steps, regions=data.draw(st.integers(1, 4)))
        if steps:
            moved = data.draw(st.lists(st.integers(0, steps - 1), unique=True))
            store.move(moved, rng.normal(size=(len(moved), 3)))
            for node in data.draw(st.lists(st.integers(0, steps - 1), max_size=5)):
                store.supersede(node)
        store.save_map(rng.bytes(100))
        query = unit(rng, 1)[0]
        expected = (store.search(query, 10), store.ids, store.poses(range(steps)), store.edges(), store.load_map())
    with opened(path) as store:
        found = (store.search(query, 10), store.ids, store.poses(range(steps)), store.edges(), store.load_map())
    for a, b in zip(expected, found, strict=True):
        if isinstance(a, tuple):
            for x, y in zip(a, b, strict=True):
                np.testing.assert_array_equal(x, y)
        else:
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"pose": (0, 0)}, "pose must be"),
        ({"vectors": np.ones((1, DIM + 1))}, "vectors must be"),
        ({"vectors": np.ones((5, DIM)), "bearings": np.zeros(5)}, "vectors must be"),
        ({"bearings": [0.0, 1.0]}, "bearings"),
        ({"reach": [1.0, 2.0]}, "reach must be"),
        ({"pose": (0, np.nan, 0)}, "NaN"),
        ({"vectors": np.full((1, DIM), np.inf)}, "NaN or infinity"),
    ],
)
def test_bad_views_are_refused_and_leave_no_trace(change, message):
    store = opened()
    view = {"stamp": 0.0, "pose": (0, 0, 0), "covariance": np.eye(3), "vectors": np.ones((1, DIM)), "bearings": [0.0]}
    with pytest.raises(ValueError, match=message):
        store.add(**view | change)
    assert len(store) == 0 and store.add(**view) == 0


def test_unknown_ids_are_named():
    store = opened()
    walk(store, np.random.default_rng(6), 3)
    with pytest.raises(IndexError, match="nodes 0 to 2"):
        store.poses([3])
    with pytest.raises(IndexError):
        store.supersede(-1)


def test_keyframes_and_map_survive(tmp_path):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        store.add(0.0, (0, 0, 0), np.eye(3), np.ones((1, DIM)), [0.0], keyframe=b"jpeg")
        assert store.load_map() is None
        store.save_map(b"first")
        store.save_map(b"second")
    with opened(path) as store:
        assert store.keyframe(0) == b"jpeg" and store.load_map() == b"second"


def test_the_first_node_of_a_session_is_linked_to_the_nearest_of_old_as_well_as_the_robot_knows_where_it_is(tmp_path):
    path, rng = tmp_path / "home.vlpg", np.random.default_rng(7)
    with opened(path) as store:
        walk(store, rng, 5)
    with opened(path) as store:
        assert store.add(0.0, (3.1, 0.6, 0.3), COVARIANCE, unit(rng, 1), [0.0]) == 5
        assert store.add(0.1, (3.2, 0.6, 0.3), COVARIANCE, unit(rng, 1), [0.0]) == 6
        edges = store.edges()
    assert list(zip(edges.i.tolist(), edges.j.tolist(), edges.kinds))[-2:] == [(3, 5, "session"), (5, 6, "odometry")]
    np.testing.assert_allclose(edges.transforms[-2], between((3, 0.5, 0.3), (3.1, 0.6, 0.3)), atol=1e-9)
    turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    doubt = turn @ np.linalg.inv(edges.information[-2]) @ turn.T  # in the map frame
    assert (np.linalg.eigvalsh(doubt - COVARIANCE) > 0).all() and np.abs(doubt - COVARIANCE).max() < 1e-3


def test_a_later_tour_takes_the_same_views_again_in_place_of_the_old_ones(tmp_path):
    path, rng = tmp_path / "home.vlpg", np.random.default_rng(3)
    views = unit(rng, 3)
    for tour in (1, 2):
        with opened(path, VlpgConfig()) as store:
            store.begin_tour()
            for x, view in enumerate(views):
                assert store.add(0.0, (x, 0, 0), COVARIANCE, view, [0.0]) is not None
                assert store.add(0.1, (x, 0, 0), COVARIANCE, view, [0.0]) is None
            assert len(store) == 3 and store.tours(store.ids).tolist() == [tour] * 3
    with opened(path, VlpgConfig()) as store:
        assert store.tours(store.held).tolist() == [1, 1, 1, 2, 2, 2] and store.ids.tolist() == [3, 4, 5]


def test_covariances_that_do_not_fit_move_nothing():
    store = opened()
    walk(store, np.random.default_rng(0), 3)
    before = store.poses(store.ids)
    with pytest.raises(ValueError, match="need covariances"):
        store.move(store.ids, before + 1.0, np.eye(3)[None])
    store.flush()
    np.testing.assert_array_equal(store.poses(store.ids), before)
