"""What goes when a store is full."""

import sqlite3

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.memory.store import VlpgConfig
from tests.edge.memory.stores import COVARIANCE, DENSE, DIM, opened, unit, walk


def in_one_piece(store):
    """Whether the edges tie all nodes together, and nothing else."""
    edges, graph = store.edges(), networkx.Graph()
    graph.add_nodes_from(store.held.tolist())
    graph.add_edges_from(zip(edges.i.tolist(), edges.j.tolist(), strict=True))
    return len(graph) == len(store.held) and networkx.is_connected(graph)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), limit=st.integers(1, 12), audit=st.integers(0, 3), sessions=st.integers(1, 4))
def test_never_more_nodes_than_the_limit_in_one_piece_and_the_same_when_reopened(
    tmp_path_factory, seed, limit, audit, sessions
):
    rng, path = np.random.default_rng(seed), tmp_path_factory.mktemp("store") / "home.vlpg"
    config, newest = VlpgConfig(limit=limit, audit=audit), -1
    for _ in range(sessions):
        with opened(path, config) as store:
            for _ in range(rng.integers(1, 30)):
                # Few places and few pictures, so that views are refused, superseded and dropped.
                pose = (*rng.integers(0, 3, 2), rng.integers(-1, 2))
                view = np.eye(DIM)[rng.integers(0, 3, 2)] + rng.normal(0, 0.01, (2, DIM))
                node = store.add(0.0, pose, COVARIANCE, view, [0.0, 0.1], b"jpeg")
                if node is None:
                    continue
                assert node > newest
                newest = node
                if rng.uniform() < 0.3 and len(store.held) > 1:
                    store.link(int(rng.choice(store.held[:-1])), node)
                assert len(store) <= limit and len(store.held) - len(store) <= audit + 1
                assert in_one_piece(store)
            edges, query = store.edges(), unit(rng, 1)[0]
            expected = store.search(query, 50), store.ids, store.held, store.poses(store.held), *edges[:4]
            assert edges.kinds.count("loop") <= len(store.held) + 9
        with opened(path, config) as store:
            found = store.search(query, 50), store.ids, store.held, store.poses(store.held), *store.edges()[:4]
        for a, b in zip(expected, found, strict=True):
            for x, y in zip(a, b, strict=True) if isinstance(a, tuple) else [(a, b)]:
                np.testing.assert_array_equal(x, y)


def test_what_is_dropped_leaves_nothing_behind(tmp_path):
    path = tmp_path / "home.vlpg"
    with opened(path, VlpgConfig(gate=DENSE.gate, limit=5)) as store:
        walk(store, np.random.default_rng(8), 40)
        assert len(store) == len(store.held) == 5 and store.held[-1] == 39
        with pytest.raises(IndexError):
            store.poses([0])
    db = sqlite3.connect(path)
    left = [db.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in ("node", "embedding", "edge")]
    assert left == [5, 20, 4]


def test_of_the_superseded_the_last_ones_stay_for_audit():
    store = opened(config=VlpgConfig(gate=DENSE.gate, audit=2))
    walk(store, np.random.default_rng(2), 6)
    for node in (3, 0, 1):
        store.supersede(node, by=5)
    store.supersede(2, by=4)
    store.add(0.6, (6, 0, 0), COVARIANCE, unit(np.random.default_rng(0), 1), [0.0])
    assert store.held.tolist() == [1, 3, 4, 5, 6] and in_one_piece(store)


def test_a_smaller_limit_thins_an_old_store(tmp_path):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        walk(store, np.random.default_rng(9), 30)
    with opened(path, VlpgConfig(gate=DENSE.gate, limit=10)) as store:
        store.add(9.0, (50, 0, 0), COVARIANCE, unit(np.random.default_rng(1), 4), np.zeros(4))
        assert len(store) == 10 and in_one_piece(store)
