import os
import sqlite3
import subprocess
import sys

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.memory.database import EncoderMismatch, StoreError
from edge.memory.gate import GateConfig
from edge.memory.store import Vlpg, VlpgConfig
from edge.pose import between

DIM = 32
COVARIANCE = np.array([[0.01, 0.002, 0.0], [0.002, 0.02, 0.001], [0.0, 0.001, 0.005]])
DENSE = VlpgConfig(gate=GateConfig(policy="dense", disagreement=-1.0))


def opened(path=":memory:", config=DENSE, encoder="tower", digest="ab" * 32, dim=DIM):
    return Vlpg.open(path, encoder, digest, dim, config)


def unit(rng, n, dim=DIM):
    rows = rng.normal(size=(n, dim)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def walk(store, rng, steps, regions=4):
    """Adds ``steps`` random views along a line; returns their vectors."""
    views = [unit(rng, regions, store.dim) for _ in range(steps)]
    for n, vectors in enumerate(views):
        assert store.add(n / 10, (n, 0.5, 0.1 * n), COVARIANCE, vectors, np.linspace(-0.4, 0.4, regions)) == n
    return views


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


def test_a_killed_process_loses_at_most_one_transaction(tmp_path):
    path = tmp_path / "home.vlpg"
    script = f"""
import os, numpy as np
from edge.memory.store import Vlpg, VlpgConfig
from edge.memory.gate import GateConfig
config = VlpgConfig(gate=GateConfig(policy="dense"), commit_every=10)
store = Vlpg.open({str(path)!r}, "tower", "ab" * 32, {DIM}, config)
store.save_map(b"the map")
for n in range(57):
    store.add(n, (n, 0, 0), np.eye(3), np.eye({DIM})[:1], [0.0])
os.kill(os.getpid(), 9)
"""
    assert subprocess.run([sys.executable, "-c", script], timeout=30).returncode == -9
    with opened(path) as store:
        assert len(store) == 50 and store.load_map() == b"the map"


def test_another_encoder_is_refused_by_name(tmp_path):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        walk(store, np.random.default_rng(3), 3)
    for other in ({"encoder": "other"}, {"digest": "cd" * 32}, {"dim": 16}):
        with pytest.raises(EncoderMismatch, match=r"vlpg reindex .*home\.vlpg"):
            opened(path, **other)
    with opened(path) as store:
        assert len(store) == 3


def test_a_file_that_is_no_store_is_left_alone(tmp_path):
    path = tmp_path / "home.vlpg"
    path.write_bytes(b"dear diary, " * 1000)
    with pytest.raises(StoreError, match="not a readable VLPG store.*left as it is"):
        opened(path)
    assert path.read_bytes() == b"dear diary, " * 1000


def test_a_damaged_store_is_noticed_at_once_and_left_alone(tmp_path):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        walk(store, np.random.default_rng(5), 200)
    data = bytearray(path.read_bytes())
    data[4096 * 3 : 4096 * 12] = os.urandom(4096 * 9)
    path.write_bytes(data)
    with pytest.raises(StoreError, match="restore a copy"):
        opened(path)
    assert path.read_bytes() == bytes(data)


def test_another_sqlite_file_is_no_store(tmp_path):
    path = tmp_path / "home.vlpg"
    db = sqlite3.connect(path)
    db.execute("CREATE TABLE t(x)")
    db.close()
    with pytest.raises(StoreError, match="not a readable VLPG store"):
        opened(path)


def test_a_folder_that_does_not_exist(tmp_path):
    with pytest.raises(StoreError, match="folder exists"):
        opened(tmp_path / "nowhere" / "home.vlpg")


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


@pytest.mark.parametrize("limit", [VlpgConfig.limit, 15])
def test_after_a_full_disk_ram_holds_what_the_file_does_and_there_is_a_way_on(tmp_path, limit):
    path, rng = tmp_path / "home.vlpg", np.random.default_rng(0)
    with opened(path, VlpgConfig(gate=DENSE.gate, limit=limit)) as store:
        walk(store, rng, 30)
        store._db.execute(f"PRAGMA max_page_count={store._db.execute('PRAGMA page_count').fetchone()[0] + 8}")
        given = 30
        with pytest.raises(sqlite3.OperationalError, match="full"):
            for given in range(30, 300):
                store.add(given, (given, 0, 0), COVARIANCE, unit(rng, 4), np.zeros(4), keyframe=bytes(3000))
        held = store.held.tolist()
        assert 0 < len(held) < given + 1
        assert [store.scan(node) for node in held] == [None] * len(held)  # each can be read
        assert store.search(unit(rng, 1)[0], 50).ids.max() <= held[-1]
        store._db.execute("PRAGMA max_page_count=100000")
        ids = [store.add(300 + n, (300 + n, 0, 0), COVARIANCE, unit(rng, 4), np.zeros(4)) for n in range(3)]
        assert ids == list(range(ids[0], ids[0] + 3)) and ids[0] > held[-1]  # never given twice
        held = store.held.tolist()
    with opened(path) as store:
        assert store.held.tolist() == held
        edges = store.edges()
        graph = networkx.Graph(zip(edges.i.tolist(), edges.j.tolist(), strict=True))
        assert set(graph) == set(held) and networkx.is_connected(graph)


def test_bytes_on_disk_and_in_ram_per_vector(tmp_path):
    """At most 2.5 x the embedding bytes on disk and 1.5 x in RAM, log and page cache included."""
    path, nodes, dim = tmp_path / "home.vlpg", 6000, 512
    script = f"""
import os, re, sys, numpy as np
from edge.memory.store import Vlpg, VlpgConfig
from edge.memory.gate import GateConfig
def resident():  # not PSS: that also grows when another process ends that shared a library with this one
    return int(re.search(r"Rss:\\s+(\\d+)", open("/proc/self/smaps_rollup").read())[1]) * 1024
rng = np.random.default_rng(0)
warm = Vlpg.open(":memory:", "tower", "d", {dim}, VlpgConfig(gate=GateConfig(policy="dense")))
for n in range(20):
    warm.add(n, (n, 0, 0), np.eye(3), rng.normal(size=(1, {dim})), [0.0])
warm.search(np.ones({dim}), 50)
before = resident()
store = Vlpg.open(sys.argv[1], "tower", "d", {dim}, VlpgConfig(gate=GateConfig(policy="dense"), limit={nodes}))
for n in range({nodes}):
    store.add(n, (n, 0, 0), np.eye(3), rng.normal(size=(1, {dim})), [0.0])
store.search(np.ones({dim}), 50)
store.flush()
disk = sum(os.path.getsize(sys.argv[1] + tail) for tail in ("", "-wal"))
print(store.nbytes, resident() - before, disk)
"""
    run = subprocess.run([sys.executable, "-c", script, path], capture_output=True, text=True, timeout=60, check=True)
    arrays, grown, disk = (int(word) for word in run.stdout.split())
    assert arrays <= 1.5 * dim * nodes
    assert grown <= 1.5 * dim * nodes + 2_000_000  # SQLite's cache, and what the allocator holds back whatever the size
    assert disk <= 2.5 * dim * nodes
    assert path.stat().st_size <= 2.5 * dim * nodes


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


@pytest.mark.parametrize("schema", ["1", "2"])
def test_a_store_of_an_older_schema_is_brought_up_to_date(tmp_path, schema):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        walk(store, np.random.default_rng(4), 3)
    db = sqlite3.connect(path)
    db.execute("ALTER TABLE node DROP COLUMN tour")
    db.execute("ALTER TABLE node DROP COLUMN reach")
    if schema == "1":
        db.execute("ALTER TABLE node DROP COLUMN scan")
    db.execute("UPDATE meta SET value=? WHERE key='schema'", (schema,))
    db.commit()
    db.close()
    for _ in range(2):
        with opened(path) as store:
            assert len(store) == 3 and store.tours(store.ids).tolist() == [0, 0, 0] and store.scan(0) is None


def test_covariances_that_do_not_fit_move_nothing():
    store = opened()
    walk(store, np.random.default_rng(0), 3)
    before = store.poses(store.ids)
    with pytest.raises(ValueError, match="need covariances"):
        store.move(store.ids, before + 1.0, np.eye(3)[None])
    store.flush()
    np.testing.assert_array_equal(store.poses(store.ids), before)
