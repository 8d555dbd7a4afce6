"""The file of a store: damaged, of another encoder or release, on a full disk; its size."""

import os
import sqlite3
import subprocess
import sys

import networkx
import numpy as np
import pytest

from edge.memory.database import EncoderMismatch, StoreError
from edge.memory.store import VlpgConfig
from tests.edge.memory.stores import COVARIANCE, DENSE, DIM, opened, unit, walk


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


def test_one_robot_at_a_time(tmp_path):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        walk(store, np.random.default_rng(3), 3)
        with pytest.raises(StoreError, match="in use; stop the robot"):
            opened(path)
        store.save_map(b"it goes on")
    with opened(path) as store:
        assert len(store) == 3 and store.load_map() == b"it goes on"


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


def test_a_store_knows_the_size_of_its_file_before_all_is_written(tmp_path):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        walk(store, np.random.default_rng(4), 30)
        disk = store.disk
    assert disk == path.stat().st_size


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
    old = sqlite3.connect(tmp_path / f"home.vlpg.schema-{schema}")
    assert old.execute("SELECT value FROM meta WHERE key='schema'").fetchone() == (schema,)
    assert old.execute("SELECT count(*) FROM node").fetchone() == (3,)
    old.close()


def test_a_whole_store_that_may_not_be_written_is_not_called_damaged(tmp_path, monkeypatch):
    """As SQLite says it where the file, or its folder, is not ours; this may be root, who may write everything."""
    path = tmp_path / "home.vlpg"
    opened(path).close()

    def refuse(db, path):
        raise sqlite3.OperationalError("attempt to write a readonly database")

    monkeypatch.setattr("edge.memory.database._upgrade", refuse)
    with pytest.raises(StoreError, match="may be written") as told:
        opened(path)
    assert "map anew" not in str(told.value)


@pytest.mark.parametrize(
    "harm",
    [
        "UPDATE embedding SET vector = x'0102'",
        "UPDATE node SET reach = x'0102'",
        "UPDATE node SET tour = 1000000000000",
        "DROP TABLE embedding",
    ],
)
def test_content_that_cannot_be_is_told_and_lets_go_of_the_file(tmp_path, harm):
    path = tmp_path / "home.vlpg"
    with opened(path) as store:
        walk(store, np.random.default_rng(5), 5)
    with sqlite3.connect(path) as db:
        db.execute(harm)
    db.close()
    for _ in range(2):  # the second time, nobody has it open
        with pytest.raises(StoreError, match="restore a copy"):
            opened(path)
