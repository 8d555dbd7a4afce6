"""Against GTSAM, which finds the same where an edge leads past a node as where it led through it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.memory.database import connect
from edge.memory.edges import EdgeTable
from edge.pose import compose

pytest.importorskip("gtsam")
from host.pose_graph import optimise  # noqa: E402


def table(nodes=0):
    db = connect(":memory:", "tower", "ab", 4)
    blank = [(node, 0.0, 0.0, 0.0, 0.0, b"") for node in range(nodes)]
    db.executemany("INSERT INTO node(id, stamp, x, y, theta, covariance) VALUES (?, ?, ?, ?, ?, ?)", blank)
    return EdgeTable(db)


def random_information(rng):
    root = rng.normal(size=(3, 3)) + 3 * np.eye(3)
    return 1e4 * root @ root.T


def solved(edges, start):
    """Poses and covariances by node, when all is trusted."""
    ends = np.column_stack([edges.i, edges.j])
    ids = np.unique(ends)
    poses, covariances = optimise(
        ids, [start[node] for node in ids], ends, edges.transforms, edges.information, np.ones(len(ends), bool)
    )
    return dict(zip(ids.tolist(), zip(poses, covariances, strict=True), strict=True))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(3, 8), data=st.data())
def test_in_a_tree_nobody_notices_that_a_node_is_gone(seed, count, data):
    rng, edges, poses = np.random.default_rng(seed), table(), {0: np.zeros(3)}
    for node in range(1, count):
        other = int(rng.integers(node))
        way = rng.uniform(-2, 2, 3)
        poses[node] = compose(poses[other], way)
        if rng.uniform() < 0.5:
            edges.add(other, node, way, random_information(rng), "odometry")
        else:
            back = compose([0, 0, -way[2]], [-way[0], -way[1], 0])
            edges.add(node, other, back, random_information(rng), "odometry")
    before, gone = solved(edges.all(), poses), data.draw(st.integers(1, count - 1))
    neighbours = [e for e in zip(edges.all().i, edges.all().j) if gone in e]
    edges.bypass(gone)
    left = edges.all()
    assert len(left.i) == count - 2 and gone not in np.concatenate([left.i, left.j])
    if len(left.i) == 0:
        return
    for node, (pose, covariance) in solved(left, poses).items():
        np.testing.assert_allclose(pose, before[node][0], atol=1e-5)
        if len(neighbours) <= 2:  # of three ways through a node, no two edges say all that they had in common
            np.testing.assert_allclose(covariance, before[node][1], atol=1e-6)


def test_the_best_known_way_leads_past_and_loops_go_along():
    edges, sharp, dull = table(4), np.eye(3) * 1e4, np.eye(3)
    edges.add(0, 1, (1, 0, 0), dull, "odometry")
    edges.add(1, 2, (1, 0, 0), sharp, "odometry")
    edges.add(1, 3, (0, 1, 0), sharp * 10, "loop")
    edges.add(2, 1, (-1, 0, 0), sharp, "loop")
    edges.bypass(1)
    left = edges.all()
    assert list(zip(left.i.tolist(), left.j.tolist(), left.kinds, strict=True)) == [(2, 0, "odometry"), (2, 3, "loop")]
    np.testing.assert_allclose(left.transforms, [[-2, 0, 0], [-1, 1, 0]], atol=1e-12)
    assert left.trusted.tolist() == [True, False]


@pytest.mark.parametrize("kinds", [("session", "odometry"), ("odometry", "session")])
def test_a_way_past_is_trusted_no_more_than_its_worse_half(kinds):
    edges = table(3)
    edges.add(0, 1, (1, 0, 0), np.eye(3) * 1e4, kinds[0])
    edges.add(1, 2, (1, 0, 0), np.eye(3), kinds[1])
    edges.bypass(1)
    assert edges.all().kinds == ["session"]


def test_there_are_never_more_loops_than_nodes_and_the_newest_stay():
    edges = table(3)
    edges.add(0, 1, (1, 0, 0), np.eye(3), "odometry")
    for x in range(9):
        edges.add(0, 2, (x, 0, 0), np.eye(3), "loop")
    edges.bypass(1)
    assert edges.all().transforms[:, 0].tolist() == [6, 7, 8]
