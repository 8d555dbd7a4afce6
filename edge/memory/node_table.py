"""The nodes of the graph in the store's file: poses, vectors, pictures and scans."""

import numpy as np

from edge.memory.database import PER_NODE, pack_symmetric


class NodeTable:
    """What ``Nodes`` and ``Vectors`` hold in RAM and more, for the next session and for ``vlpg reindex``."""

    def __init__(self, db):
        self._db = db

    def add(self, node, stamp, view, keyframe, scan, tour):
        """A new node from a ``View``; ``keyframe`` and ``scan`` are bytes or None."""
        reach = view.reach.tobytes() if view.reach.any() else None
        covariance = pack_symmetric(view.covariance)
        self._db.execute(
            "INSERT INTO node(id, stamp, x, y, theta, covariance, keyframe, scan, tour, reach)"
            " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            (node, float(stamp), *view.pose.tolist(), covariance, keyframe, scan, tour, reach),
        )

    def add_vectors(self, node, matrix, scales, bearings):
        """The quantised rows ``(R, D)`` of a node, their scales and bearings ``(R,)``."""
        self._db.executemany(
            "INSERT INTO embedding VALUES (?, ?, ?, ?)",
            [
                (PER_NODE * node + region, float(bearings[region]), float(scales[region]), matrix[region].tobytes())
                for region in range(len(matrix))
            ],
        )

    def move(self, ids, poses, covariances):
        """New poses ``(N, 3)`` and, unless None, covariances ``(N, 3, 3)`` of nodes."""
        self._db.executemany(
            "UPDATE node SET x=?, y=?, theta=? WHERE id=?",
            [(*pose, node) for pose, node in zip(poses.tolist(), ids.tolist(), strict=True)],
        )
        if covariances is not None:
            self._db.executemany(
                "UPDATE node SET covariance=? WHERE id=?",
                [(pack_symmetric(c), node) for c, node in zip(covariances, ids.tolist(), strict=True)],
            )

    def supersede(self, node, by):
        """``node`` answers no more: its vectors go, the rest stays."""
        self._db.execute("UPDATE node SET superseded_by=? WHERE id=?", (by, node))
        self._drop_vectors(node)

    def longest_superseded(self, count):
        """Ids of ``count`` superseded nodes, those first that were first replaced; never the newest node."""
        rows = self._db.execute(
            "SELECT id FROM node WHERE superseded_by IS NOT NULL AND id < (SELECT max(id) FROM node)"
            " ORDER BY superseded_by, id LIMIT ?",
            (count,),
        )
        return [node for (node,) in rows.fetchall()]

    def drop(self, node):
        """Nothing is left of ``node``."""
        self._drop_vectors(node)
        self._db.execute("DELETE FROM node WHERE id=?", (node,))

    def read(self, column, ids):
        """What the file has in ``column`` for nodes with these ids, a list."""
        return [self._db.execute(f"SELECT {column} FROM node WHERE id=?", (node,)).fetchone()[0] for node in ids]

    def all(self):
        """Id, pose (3,), whether it answers, tour and reach, of every node by id."""
        rows = self._db.execute("SELECT id, x, y, theta, superseded_by IS NULL, tour, reach FROM node ORDER BY id")
        return ((node, pose, answers, tour, reach) for node, *pose, answers, tour, reach in rows)

    def vectors(self, dim):
        """Pieces of all vectors by id of their node: owners, matrix (M, D) int8, scales, bearings."""
        cursor = self._db.execute(
            "SELECT e.id / ?1, e.bearing, e.scale, e.vector FROM embedding e JOIN node n ON n.id = e.id / ?1"
            " WHERE n.superseded_by IS NULL ORDER BY e.id",
            (PER_NODE,),
        )
        while rows := cursor.fetchmany(256):
            owners, bearings, scales, blobs = zip(*rows, strict=True)
            yield owners, np.frombuffer(b"".join(blobs), np.int8).reshape(len(blobs), dim), scales, bearings

    def _drop_vectors(self, node):
        self._db.execute(
            "DELETE FROM embedding WHERE id BETWEEN ? AND ?", (PER_NODE * node, PER_NODE * node + PER_NODE - 1)
        )
