"""The edges of the graph, in the store's file: relative poses that were measured, and how well they are known."""

from typing import NamedTuple

import numpy as np

from edge.memory.database import pack_symmetric, unpack_symmetric
from edge.pose import between, compose, rotation


class Edges(NamedTuple):
    """Relative pose measurements between nodes."""

    i: np.ndarray  # (E,) int64 ids
    j: np.ndarray  # (E,) int64
    transforms: np.ndarray  # (E, 3) pose of j seen from i: m, m, rad
    information: np.ndarray  # (E, 3, 3) inverse covariances, in the frame of i
    kinds: list[str]  # E times "odometry", "session" (the first node since the robot was switched on) or "loop"

    @property
    def trusted(self):
        """``(E,)`` bool: odometry may be inexact, but only a place that was recognized can be another place."""
        return np.array(self.kinds, str) == "odometry"


class EdgeTable:
    """Odometry and session edges are a tree over all nodes, so the graph is in one piece; loops come on top."""

    def __init__(self, db):
        self._db = db

    def add(self, i: int, j: int, transform, information, kind: str) -> None:
        """The pose of ``j`` was seen to be ``transform (3,)`` from ``i``; ``information (3, 3)`` in the frame of i."""
        self._db.execute(
            "INSERT INTO edge(i, j, dx, dy, dtheta, information, kind) VALUES (?, ?, ?, ?, ?, ?, ?)",
            (i, j, *np.asarray(transform, float).tolist(), pack_symmetric(information), kind),
        )

    def all(self) -> Edges:
        """In the order they were added."""
        rows = self._db.execute("SELECT i, j, dx, dy, dtheta, information, kind FROM edge ORDER BY id").fetchall()
        return Edges(
            np.array([r[0] for r in rows], np.int64),
            np.array([r[1] for r in rows], np.int64),
            np.array([r[2:5] for r in rows], float).reshape(-1, 3),
            np.array([unpack_symmetric(r[5]) for r in rows]).reshape(-1, 3, 3),
            [r[6] for r in rows],
        )

    def bypass(self, node: int) -> None:
        """Lead the edges of ``node`` past it: from its best known neighbour in the tree straight to the others.

        The tree stays one (Konolige & Bowman 2009 take views out of a map in this way, where marginalising would
        tie all neighbours to each other). Of the loops there are never more than nodes: the oldest go.
        """
        rows = self._db.execute(
            "SELECT id, i, j, dx, dy, dtheta, information, kind FROM edge WHERE ?1 IN (i, j)", (node,)
        ).fetchall()
        ways = []  # id of the edge, the other end, its pose seen from the node, its covariance there, kind
        for edge, i, j, *transform, blob, kind in rows:
            way = np.array(transform), np.linalg.inv(unpack_symmetric(blob))
            ways.append((edge, i + j - node, *(way if i == node else _reversed(*way)), kind))
        hub = min(ways, key=lambda way: (way[-1] == "loop", np.trace(way[3])), default=None)
        for edge, other, transform, covariance, kind in ways:
            if other == hub[1]:
                self._db.execute("DELETE FROM edge WHERE id=?", (edge,))
                continue
            past, doubt = _one_after_the_other(*_reversed(*hub[2:4]), transform, covariance)
            self._db.execute(
                "UPDATE edge SET i=?, j=?, dx=?, dy=?, dtheta=?, information=?, kind=? WHERE id=?",
                (
                    *(hub[1], other, *past.tolist(), pack_symmetric(np.linalg.inv(doubt))),
                    kind if hub[-1] == "odometry" or kind == "loop" else hub[-1],  # no better than its worse half
                    edge,
                ),
            )
        self._db.execute(
            "DELETE FROM edge WHERE id IN (SELECT id FROM edge WHERE kind='loop' ORDER BY id DESC LIMIT -1"
            " OFFSET (SELECT count(*) FROM node))"
        )


def _one_after_the_other(first, first_covariance, second, second_covariance):
    """Transform (3,) and covariance (3, 3) of a way that is two ways (Smith, Self & Cheeseman 1990, Eq. 5)."""
    way = compose(first, second)
    lever = np.eye(3)
    lever[0, 2], lever[1, 2] = first[1] - way[1], way[0] - first[0]
    turn = rotation(first[2])
    return way, lever @ first_covariance @ lever.T + turn @ second_covariance @ turn.T


def _reversed(transform, covariance):
    """The way back (Smith, Self & Cheeseman 1990, Eq. 8); its covariance is in the frame of the other end."""
    back = between(transform, np.zeros(3))
    jacobian = -rotation(-transform[2])
    jacobian[0, 2], jacobian[1, 2] = back[1], -back[0]
    return back, jacobian @ covariance @ jacobian.T
