import numpy as np
import pytest
from msgspec import structs

from edge.link.reports import graph_reply
from edge.link.requests import Array, Vectors, pack, unpack
from edge.memory.gate import GateConfig
from edge.memory.store import Vlpg, VlpgConfig
from host.replica import Replica

DIM = 16


class Encoder:
    name, digest = "tower", "abc"


@pytest.fixture
def memory():
    return Vlpg.open(":memory:", "tower", "abc", DIM, VlpgConfig(gate=GateConfig(policy="dense", disagreement=-1.0)))


def see(memory, rng, count):
    for _ in range(count):
        vectors = rng.normal(size=(2, DIM))
        memory.add(0.0, rng.normal(size=3), np.eye(3), vectors / np.linalg.norm(vectors, axis=1)[:, None], [0.0, 0.3])


def follow(replica, memory):
    reply = graph_reply(memory, Encoder, replica.next)
    replica.update(unpack(type(reply), pack(reply)))
    return reply


def test_the_copy_answers_as_the_robot_does(memory):
    rng, replica = np.random.default_rng(0), Replica(DIM, memory.id)
    for round_ in range(5):
        see(memory, rng, 20)
        if round_:
            memory.supersede(int(rng.choice(memory.ids)))
            memory.move([3], rng.normal(size=(1, 3)))
        follow(replica, memory)
        query = rng.normal(size=DIM)
        hits, poses = replica.search(query, 500)
        expected = memory.search(query, 500)
        np.testing.assert_array_equal(hits.ids, expected.ids)
        np.testing.assert_allclose(hits.scores, expected.scores, rtol=1e-6)
        np.testing.assert_allclose(poses, memory.poses(hits.ids))
        assert len(replica) == len(memory)


def test_only_what_is_new_travels(memory):
    rng, replica = np.random.default_rng(1), Replica(DIM, memory.id)
    see(memory, rng, 10)
    assert len(follow(replica, memory).vectors.owners.numpy()) == 20
    see(memory, rng, 1)
    assert len(follow(replica, memory).vectors.owners.numpy()) == 2
    assert len(follow(replica, memory).vectors.owners.numpy()) == 0


def test_what_a_crash_undid_is_another_memory(tmp_path):
    """Nodes that were not committed travel, too; after a crash their ids are given again."""
    path, names = tmp_path / "home.vlpg", []
    for seed in (0, 1):
        memory = Vlpg.open(path, "tower", "abc", DIM)
        see(memory, np.random.default_rng(seed), 3)
        names.append(graph_reply(memory, Encoder, 0).memory)
        memory._db.execute("ROLLBACK")
        memory.close()
    assert names[0] != names[1] and names[0].split(".")[0] == names[1].split(".")[0]


def test_an_empty_memory(memory):
    replica = Replica(DIM, memory.id)
    follow(replica, memory)
    hits, poses = replica.search(np.ones(DIM), 5)
    assert len(hits.ids) == 0 and poses.shape == (0, 3)


def test_arrays_that_do_not_fit_are_refused(memory):
    see(memory, np.random.default_rng(2), 3)
    reply = graph_reply(memory, Encoder, 0)
    with pytest.raises(ValueError, match="vectors"):
        Replica(DIM + 1, memory.id).update(reply)
    short = Vectors(reply.vectors.owners, reply.vectors.data, Array.of(np.ones(1, np.float32)), reply.vectors.bearings)
    broken = structs.replace(reply, vectors=short)
    with pytest.raises(ValueError, match="scales"):
        Replica(DIM, memory.id).update(broken)
