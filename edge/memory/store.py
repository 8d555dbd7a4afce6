"""The visual language pose graph (VLPG) of a home: poses, what was seen from them, and how they are linked."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from edge.memory.database import PER_NODE, StoreError, connect
from edge.memory.gate import GateConfig, judge
from edge.memory.motion import MotionNoise
from edge.memory.vectors import Vectors, grown, quantize
from edge.pose import between


@dataclass(frozen=True)
class VlpgConfig:
    """Policies of the store."""

    gate: GateConfig = field(default_factory=GateConfig)
    motion: MotionNoise = field(default_factory=MotionNoise)
    commit_every: int = 20  # nodes a transaction: 2 s of dense mapping at most are lost when the process dies


class Edges(NamedTuple):
    """Relative pose measurements between nodes."""

    i: np.ndarray  # (E,) int64 ids
    j: np.ndarray  # (E,) int64
    transforms: np.ndarray  # (E, 3) pose of j seen from i: m, m, rad
    information: np.ndarray  # (E, 3, 3) inverse covariances, in the frame of i
    kinds: list[str]  # E times "odometry" or "loop"


class Vlpg:
    """[V] Sec. III-A. Node ids count from 0 in the order of admission and never change; nothing is ever deleted.

    On disk everything in one SQLite file; in RAM the poses and the int8 vectors that answer queries. Writes are grouped
    into transactions of ``commit_every`` nodes; ``flush`` ends the current one. One thread at a time.
    """

    def __init__(self, db, dim, config):
        """Use ``Vlpg.open``."""
        self.config = config
        self.dim = dim
        self._db = db
        self._vectors = Vectors(dim)
        self._poses = np.empty((0, 3))
        self._alive = np.empty(0, bool)
        self._count = 0
        self._last = None  # id of the node that the next one is linked to; None at the start of a session
        self._pending = 0
        self._load()

    @classmethod
    def open(cls, path, encoder_name, encoder_digest, dim, config=None):
        """Opens the store at ``path``, or makes it; ``":memory:"`` keeps it in RAM.

        Args:
            path: file of the home.
            encoder_name, encoder_digest: whose vectors these are (name and sha256 of the manifest's image tower).
            dim: components of a vector.
            config: VlpgConfig.

        Raises:
            StoreError: the file is no store, damaged or not accessible; it is left as it is.
            EncoderMismatch: the store was made with another encoder; the message names ``vlpg reindex``.
        """
        return cls(connect(path, encoder_name, encoder_digest, dim), dim, config or VlpgConfig())

    def __len__(self):
        """Number of nodes that answer queries."""
        return int(self._alive[: self._count].sum())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def nbytes(self):
        """Bytes in RAM of vectors, poses and their spare capacity."""
        return self._vectors.nbytes + self._poses.nbytes + self._alive.nbytes

    @property
    def ids(self):
        """Ids ``(N,)`` int64 of the nodes that answer queries."""
        return np.flatnonzero(self._alive[: self._count])

    def add(self, stamp, pose, covariance, vectors, bearings, keyframe=None, scan=None):
        """Offers a view; the gate decides whether it becomes a node.

        Args:
            stamp: s.
            pose: (3,) in the map frame.
            covariance: (3, 3) of the pose.
            vectors: (R, D) unit rows, R from 1 to 4; row 0 is the whole picture, the others its regions.
            bearings: (R,) rad from the heading, left positive.
            keyframe: JPEG bytes of the view, kept for ``vlpg reindex`` and for people to look at; or None.
            scan: the lidar scan there, packed by ``scan_bytes``, for loop closures; or None.

        Returns the new node's id, or None when the gate refused the view. A node is linked to the one admitted before
        it, and replaces nodes at (nearly) the same pose that disagree with it.

        Raises ValueError for wrong shapes or numbers that are not finite.
        """
        pose, covariance = np.asarray(pose, float), np.asarray(covariance, float)
        vectors, bearings = np.atleast_2d(np.asarray(vectors, np.float32)), np.atleast_1d(np.asarray(bearings, float))
        self._validate(pose, covariance, vectors, bearings)
        verdict = judge(
            pose,
            self._poses[: self._count],
            self._alive[: self._count],
            lambda nodes: self._vectors.cosines(nodes, vectors),
            self.config.gate,
        )
        if not verdict.admit:
            return None
        node = self._count
        matrix, scales = quantize(vectors)
        self._begin()
        self._db.execute(
            "INSERT INTO node(id, stamp, x, y, theta, covariance, keyframe, scan) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
            (node, float(stamp), *pose.tolist(), _pack(covariance), keyframe, scan),
        )
        self._db.executemany(
            "INSERT INTO embedding VALUES (?, ?, ?, ?)",
            [
                (PER_NODE * node + region, float(bearings[region]), float(scales[region]), matrix[region].tobytes())
                for region in range(len(matrix))
            ],
        )
        self._remember(pose, True)
        self._vectors.append(node, matrix, scales, bearings)
        if self._last is not None:
            self.link(self._last, node, kind="odometry")
        self._last = node
        for old in verdict.superseded:
            self.supersede(int(old), by=node)
        self._pending += 1
        if self._pending >= self.config.commit_every:
            self.flush()
        return node

    def search(self, direction, k):
        """The ``k`` embeddings that point most in ``direction (D,)``: ``Hits``, best first, one per (node, region).

        For [V] Eq. 2 the direction is t_object - t_else: with the manifest's logit scale s, sigmoid(s * score) is the
        softmax over the two prompts. Superseded nodes do not answer. Raises ValueError for a direction of another size
        or with NaN.
        """
        return self._vectors.search(direction, k)

    def cosines(self, ids, vectors):
        """Cosines ``(N, R)`` of ``vectors (R, D)`` with the regions of nodes that answer, rank by rank."""
        return self._vectors.cosines(self._known(ids), vectors)

    def poses(self, ids):
        """Poses ``(N, 3)`` of nodes, superseded ones too. Raises IndexError for an id that does not exist."""
        return self._poses[self._known(ids)]

    def move(self, ids, poses, covariances=None):
        """Corrects the ``poses (N, 3)`` (and covariances (N, 3, 3)) of nodes in place."""
        ids, poses = self._known(ids), np.asarray(poses, float).reshape(-1, 3)
        if len(ids) != len(poses) or not np.isfinite(poses).all():
            raise ValueError(f"{len(ids)} ids need as many finite poses, and {len(poses)} were given")
        self._begin()
        self._db.executemany(
            "UPDATE node SET x=?, y=?, theta=? WHERE id=?",
            [(*pose, node) for pose, node in zip(poses.tolist(), ids.tolist(), strict=True)],
        )
        if covariances is not None:
            self._db.executemany(
                "UPDATE node SET covariance=? WHERE id=?",
                [(_pack(c), node) for c, node in zip(covariances, ids.tolist(), strict=True)],
            )
        self._poses[ids] = poses
        self.flush()

    def supersede(self, node, by=None):
        """``node`` answers no more; it stays in the file for audit, with the id of the node that replaced it."""
        self._known([node])
        self._begin()
        self._db.execute("UPDATE node SET superseded_by=? WHERE id=?", (node if by is None else by, node))
        self._alive[node] = False
        self._vectors.forget(node)

    def link(self, i, j, transform=None, information=None, kind="loop"):
        """Adds an edge: the pose of ``j`` seen from ``i`` (default: from their present poses), e.g. a loop closure.

        ``information`` (3, 3) is the inverse covariance, by default that of having driven there.
        """
        i, j = (int(node) for node in self._known([i, j]))
        transform = between(self._poses[i], self._poses[j]) if transform is None else np.asarray(transform, float)
        information = self.config.motion.information(transform) if information is None else information
        self._begin()
        self._db.execute(
            "INSERT INTO edge(i, j, dx, dy, dtheta, information, kind) VALUES (?, ?, ?, ?, ?, ?, ?)",
            (i, j, *transform.tolist(), _pack(information), kind),
        )

    def edges(self):
        """All ``Edges``, in the order they were added."""
        rows = self._db.execute("SELECT i, j, dx, dy, dtheta, information, kind FROM edge ORDER BY id").fetchall()
        return Edges(
            np.array([r[0] for r in rows], np.int64),
            np.array([r[1] for r in rows], np.int64),
            np.array([r[2:5] for r in rows], float).reshape(-1, 3),
            np.array([_unpack(r[5]) for r in rows]).reshape(-1, 3, 3),
            [r[6] for r in rows],
        )

    def covariances(self, ids):
        """Covariances ``(N, 3, 3)`` of the poses of nodes (read from disk)."""
        blobs = [self._node(node, "covariance") for node in self._known(ids).tolist()]
        return np.array([_unpack(blob) for blob in blobs]).reshape(-1, 3, 3)

    def stamps(self, ids):
        """Stamps ``(N,)`` [s] of nodes (read from disk)."""
        return np.array([self._node(node, "stamp") for node in self._known(ids).tolist()], float)

    def keyframe(self, node):
        """JPEG bytes of the view of ``node``, or None when none was kept."""
        return self._node(int(self._known([node])[0]), "keyframe")

    def scan(self, node):
        """The packed scan of ``node`` (see ``scan_bytes``), or None when none was kept."""
        return self._node(int(self._known([node])[0]), "scan")

    def superseded_by(self, node):
        """Id of the node that replaced ``node`` (its own id when withdrawn by hand), or None while it answers."""
        return self._node(int(self._known([node])[0]), "superseded_by")

    def view(self, node):
        """What was seen from ``node``: vectors ``(R, D)`` float32 and bearings ``(R,)``; no rows once superseded."""
        return self._vectors.of(node)

    def export(self):
        """What answers queries, to search it elsewhere: owners (M,), int8 (M, D), scales (M,), bearings (M,)."""
        return self._vectors.export()

    def save_map(self, data):
        """Keeps the occupancy map's bytes with the graph, at once: a map is saved when it is worth keeping."""
        self._begin()
        self._db.execute("INSERT OR REPLACE INTO map VALUES (0, ?)", (data,))
        self.flush()

    def load_map(self):
        """The bytes last given to ``save_map``, or None."""
        row = self._db.execute("SELECT data FROM map").fetchone()
        return row and row[0]

    def flush(self):
        """Commits what was added so far."""
        if self._db.in_transaction:
            self._db.execute("COMMIT")
        self._pending = 0

    def close(self):
        """Commits and closes the file. The store cannot be used afterwards."""
        self.flush()
        self._db.close()

    def _load(self):
        nodes = self._db.execute("SELECT id, x, y, theta, superseded_by IS NULL FROM node ORDER BY id").fetchall()
        for expected, (node, x, y, theta, alive) in enumerate(nodes):
            if node != expected:
                raise StoreError(f"the store lacks node {expected}; restore a copy of it, or move it away to map anew")
            self._remember((x, y, theta), alive)
        cursor = self._db.execute(
            "SELECT e.id / ?1, e.bearing, e.scale, e.vector FROM embedding e JOIN node n ON n.id = e.id / ?1"
            " WHERE n.superseded_by IS NULL ORDER BY e.id",
            (PER_NODE,),
        )
        while rows := cursor.fetchmany(256):
            owners, bearings, scales, blobs = zip(*rows, strict=True)
            matrix = np.frombuffer(b"".join(blobs), np.int8).reshape(len(blobs), self.dim)
            self._vectors.append(owners, matrix, scales, bearings)

    def _remember(self, pose, alive):
        self._poses = grown(self._poses, self._count + 1)
        self._alive = grown(self._alive, self._count + 1)
        self._poses[self._count], self._alive[self._count] = pose, alive
        self._count += 1

    def _begin(self):
        if not self._db.in_transaction:
            self._db.execute("BEGIN")

    def _known(self, ids):
        ids = np.atleast_1d(np.asarray(ids, np.int64))
        if len(ids) and (ids.min() < 0 or ids.max() >= self._count):
            asked = f"{ids.min()} to {ids.max()}"
            raise IndexError(f"the store has nodes 0 to {self._count - 1}, and {asked} were asked for")
        return ids

    def _node(self, node, column):
        return self._db.execute(f"SELECT {column} FROM node WHERE id=?", (node,)).fetchone()[0]

    def _validate(self, pose, covariance, vectors, bearings):
        if pose.shape != (3,) or covariance.shape != (3, 3):
            raise ValueError(f"pose must be (3,) and covariance (3, 3), not {pose.shape} and {covariance.shape}")
        if vectors.ndim != 2 or vectors.shape[1] != self.dim or not 1 <= len(vectors) <= PER_NODE:
            raise ValueError(f"vectors must be (1 to {PER_NODE}, {self.dim}), not {vectors.shape}")
        if bearings.shape != (len(vectors),):
            raise ValueError(f"{len(vectors)} vectors need as many bearings, not {bearings.shape}")
        if not all(np.isfinite(a).all() for a in (pose, covariance, vectors, bearings)):
            raise ValueError("a view with NaN or infinity in pose, covariance, vectors or bearings cannot be stored")


_UPPER = np.triu_indices(3)


def _pack(symmetric):
    """A symmetric (3, 3) matrix as the 6 little-endian float64 of its upper triangle, row by row."""
    return np.asarray(symmetric, "<f8")[_UPPER].tobytes()


def _unpack(blob):
    matrix = np.zeros((3, 3))
    matrix[_UPPER] = np.frombuffer(blob, "<f8")
    return matrix + np.triu(matrix, 1).T
