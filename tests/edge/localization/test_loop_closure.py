"""A robot that only counts its wheels' turns, twice through a home: do closures bring its nodes back to the truth?"""

import numpy as np
import pytest

from edge.localization.loop_closure import LoopCloser, bent
from edge.memory.gate import GateConfig
from edge.memory.scan_bytes import pack
from edge.memory.store import Vlpg, VlpgConfig
from edge.pose import between, wrap
from firmware_sim.base import BaseConfig
from firmware_sim.world import World, WorldConfig
from host.pose_graph import optimise

DIM = 64
DRIFTING = BaseConfig(scale_error=0.03, slip=0.10)  # wheels more uneven and slippery than they should be


def place_vector(pose):
    """What an encoder would make of a view: alike for poses alike (random Fourier features, Rahimi & Recht 2007)."""
    rng = np.random.default_rng(7)
    x = np.array([pose[0] / 1.2, pose[1] / 1.2, 1.3 * np.cos(pose[2]), 1.3 * np.sin(pose[2])])
    phases = rng.normal(0, 1, (DIM // 2, 4)) @ x
    vector = np.concatenate([np.cos(phases), np.sin(phases)])
    return (vector / np.linalg.norm(vector)).astype(np.float32)


def memory():
    return Vlpg.open(":memory:", "places", "00", DIM, VlpgConfig(gate=GateConfig(policy="dense", disagreement=-1.0)))


@pytest.fixture(scope="module")
def driven(boxes_home, tour):
    """The memory, its nodes' true poses (N, 3), and the pairs of nodes that were tied."""
    world = World(boxes_home, 5, WorldConfig(camera=False, base=DRIFTING))
    store, last, truth, tied = memory(), np.full(3, 9.0), [], []
    closer = LoopCloser(store)
    for _ in range(2):
        guide = tour(boxes_home)
        while (twist := guide.command(world.truth)) is not None:
            seen = world.step(twist)
            x, y, turned = between(last, seen.odom)
            if seen.scan is None or np.hypot(x, y) < 0.3 and abs(turned) < np.radians(20):
                continue
            last = seen.odom
            truth.append(between(boxes_home.start, world.truth))
            scan = pack(seen.scan, between(seen.odom, seen.scan.odom))
            vector = place_vector(truth[-1])[None]
            node = store.add(seen.stamp, seen.odom, np.eye(3), vector, [0.0], scan=scan)
            tied.append((closer.consider(node), node))
    return store, np.array(truth), [pair for pair in tied if pair[0] is not None]


def position_error(poses, truth):
    return np.hypot(*(poses - truth)[:, :2].T)


def test_what_is_tied_is_the_same_place(driven):
    store, truth, tied = driven
    assert len(tied) >= 10
    edges = store.edges()
    loops = [k for k, kind in enumerate(edges.kinds) if kind == "loop"]
    assert [(edges.i[k], edges.j[k]) for k in loops] == tied
    errors = edges.transforms[loops] - between(truth[edges.i[loops]], truth[edges.j[loops]])
    assert np.median(np.hypot(*errors[:, :2].T)) < 0.04
    assert np.median(np.abs(wrap(errors[:, 2]))) < np.radians(1)


def test_optimised_nodes_lie_nearer_to_the_truth(driven):
    store, truth, _ = driven
    edges, raw = store.edges(), store.poses(store.ids)
    ends = np.stack([edges.i, edges.j], 1)
    poses, covariances = optimise(store.ids, raw, ends, edges.transforms, edges.information, edges.trusted)
    before, after = position_error(raw, truth), position_error(poses, truth)
    print(f"RMS of {len(raw)} nodes: {np.sqrt((before**2).mean()):.3f} m raw, {np.sqrt((after**2).mean()):.3f} m")
    assert np.sqrt((after**2).mean()) < 0.7 * np.sqrt((before**2).mean())
    assert covariances.shape == (len(raw), 3, 3)


def test_a_graph_is_bent_until_it_is_straightened(driven):
    store, truth, _ = driven
    raw = store.poses(store.ids)
    assert bent(store)
    store.move(store.ids, truth)
    assert not bent(store)
    store.link(0, 50, (1.0, 2.0, 3.0), np.eye(3) * 1e4)  # a false closure among many true ones
    assert not bent(store)
    store.move(store.ids, raw)
    assert bent(store) and not bent(memory())


def test_a_place_that_only_looks_the_same_is_refused(driven):
    store, _, _ = driven
    liar = memory()
    rng = np.random.default_rng(0)
    for node in range(60):  # the same picture everywhere, scans from all over
        pose = store.poses([node])[0] * [0.02, 0.02, 0]
        liar.add(node, pose, np.eye(3), place_vector(np.zeros(3))[None], [0.0], scan=store.scan(int(rng.integers(190))))
    closer = LoopCloser(liar)
    tied = [closer.consider(node) for node in range(30, 60)]
    assert sum(old is not None for old in tied) <= 3


def test_without_a_scan_nothing_is_tied():
    store = memory()
    for node in range(40):
        store.add(node, np.zeros(3), np.eye(3), place_vector(np.zeros(3))[None], [0.0])
    assert LoopCloser(store).consider(39) is None
