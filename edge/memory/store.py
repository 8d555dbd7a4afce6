"""The visual language pose graph (VLPG) of a home: poses, what was seen from them, and how they are linked."""

import secrets
import sqlite3
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from math import prod

import numpy as np

from edge.memory.database import connect, lock_store, unusable
from edge.memory.edges import EdgeTable
from edge.memory.gate import GateConfig, is_known, judge
from edge.memory.motion import MotionNoise, in_frame
from edge.memory.node_table import NodeTable
from edge.memory.nodes import PER_METRE, Nodes
from edge.memory.thinning import most_redundant
from edge.memory.vectors import Vectors, quantize
from edge.memory.view import View
from edge.pose import between


@dataclass(frozen=True)
class VlpgConfig:
    """Policies of the store."""

    gate: GateConfig = field(default_factory=GateConfig)
    motion: MotionNoise = field(default_factory=MotionNoise)
    limit: int = 2000  # nodes that answer; a home of 100 m2 mapped densely ([V] Sec. III-A), and the budget in RAM
    audit: int = 200  # superseded nodes kept, newest first; with pictures of 9 kB they cost 2 MB of disk, no vectors
    commit_every: int = 20  # nodes a transaction; who adds few must `flush` now and then

    def __post_init__(self):
        if self.limit < 1 or self.audit < 0:
            raise ValueError("a store needs a limit of at least one node, and audit of none or more")


class Vlpg:
    """[V] Sec. III-A. Node ids count from 0 in the order of admission, never change and are never given twice.

    On disk everything in one SQLite file; in RAM the poses and the int8 vectors that answer queries. At most ``limit``
    nodes answer: then the most redundant one goes for each that comes, and its edges lead past it. Writes are grouped
    into transactions of ``commit_every`` nodes; ``flush`` ends the current one. When one fails, as on a full disk,
    sqlite3.Error is raised and its nodes are gone, from RAM, too. One thread at a time. Whatever is asked about a node
    raises IndexError when its id does not exist.
    """

    def __init__(self, db, lock, dim, config):
        """Use ``Vlpg.open``."""
        self.config = config
        self._lock = lock
        self.dim = dim
        self._db = db
        self.opening = secrets.token_hex(4)  # names what was seen of it since: what a crash undoes gave ids to others
        self._table, self._edges = NodeTable(db), EdgeTable(db)
        self._load()
        self._tour = int(self._nodes.tours.max(initial=0))

    @classmethod
    def open(cls, path, encoder_name, encoder_digest, dim, config=None):
        """Opens the store at ``path``, or makes it; ``":memory:"`` keeps it in RAM.

        Args:
            path: file of the home.
            encoder_name, encoder_digest: whose vectors these are (name and sha256 of the manifest's image tower).
            dim: components of a vector.
            config: VlpgConfig.

        Raises:
            StoreError: the file is no store, damaged, not accessible or open already; it is left as it is.
            EncoderMismatch: the store was made with another encoder; the message names ``vlpg reindex``.
        """
        with ExitStack() as undo:
            lock = undo.enter_context(lock_store(path))
            db = undo.enter_context(closing(connect(path, encoder_name, encoder_digest, dim)))
            try:
                store = cls(db, lock, dim, config or VlpgConfig())
            except (sqlite3.Error, ValueError, TypeError, OverflowError) as error:
                raise unusable(path, error) from error
            undo.pop_all()
            return store

    def __len__(self):
        """Number of nodes that answer queries."""
        return int(self._nodes.answers.sum())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def nbytes(self):
        """Bytes in RAM of vectors, poses and their spare capacity."""
        return self._vectors.nbytes + self._nodes.nbytes

    @property
    def disk(self):
        """Bytes of its file, pictures and scans with them, once all is written."""
        return prod(self._db.execute(f"PRAGMA {what}").fetchone()[0] for what in ("page_count", "page_size"))

    @property
    def ids(self):
        """Ids ``(N,)`` int64 of the nodes that answer queries."""
        return self._nodes.ids[self._nodes.answers]

    @property
    def held(self):
        """Ids ``(N,)`` int64 of all nodes, superseded ones too."""
        return self._nodes.ids.copy()

    @property
    def id(self):
        """Names this memory, and no other one of the same robot."""
        return self._meta("id")

    @property
    def mapped(self):
        """Whether the home has been mapped to the end; of stores of older releases, whether there is a map."""
        mapped = self._meta("mapped")
        return self.load_map() is not None if mapped is None else mapped == "1"

    def mark_mapped(self):
        """Remember that the home has been mapped to the end."""
        self._note("mapped", "1")

    def note_camera(self, hfov):
        """Remember what field of view [rad] the pictures have, for ``vlpg reindex``."""
        self._note("hfov", repr(float(hfov)))

    def begin_tour(self):
        """From now on, views are of a new tour: what was seen before may no longer be so."""
        self._tour += 1

    def knows(self, pose, vector):
        """Whether ``add`` would refuse a view from ``pose (3,)`` whose whole picture has this ``vector (D,)``.

        True only if its regions make no difference; else let ``add`` decide.
        """
        return is_known(*self._candidate(np.asarray(pose, float), np.atleast_2d(vector)))

    def break_off(self):
        """How the robot got to where the next node is seen from is not known: it is linked as a session's first one."""
        self._last = None

    def add(self, stamp, pose, covariance, vectors, bearings, keyframe=None, scan=None, reach=None):
        """Offers a view; the gate decides whether it becomes a node.

        Args:
            stamp: s.
            pose: (3,) in the map frame.
            covariance: (3, 3) of the pose.
            vectors: (R, D) unit rows, R from 1 to 4; row 0 is the whole picture, the others its regions.
            bearings: (R,) rad from the heading, left positive.
            keyframe: JPEG bytes of the view, kept for ``vlpg reindex`` and for people to look at; or None.
            scan: the lidar scan there, packed by ``scan_bytes``, for loop closures; or None.
            reach: (COLUMNS,) m, how far the view went at columns from left to right, 0 where unknown; or None.

        Returns the new node's id, or None when the gate refused the view. A node is linked to the one admitted before
        it, or, the first since the store was opened, to the nearest one of old. It replaces nodes at (nearly) the same
        pose that disagree with it, and a redundant one when the store is full.

        Raises ValueError for wrong shapes or numbers that are not finite.
        """
        view = View.checked(self.dim, pose, covariance, vectors, bearings, reach)
        verdict = judge(*self._candidate(view.pose, view.vectors))
        if not verdict.admit:
            return None
        node = self._nodes.next
        replaced = self._nodes.ids[verdict.superseded].tolist()
        resumed = self._nodes.nearest(view.pose, self.config.gate) if self._last is None else None
        matrix, scales = quantize(view.vectors)
        with self._writing():
            self._table.add(node, stamp, view, keyframe, scan, self._tour)
            self._table.add_vectors(node, matrix, scales, view.bearings)
            self._nodes.append(node, view.pose, True, self._tour, view.reach)
            self._vectors.append(node, matrix, scales, view.bearings)
            if self._last is not None:
                self.link(self._last, node, kind="odometry")
            elif resumed is not None:
                self._resume(resumed, node, view.covariance)
            self._last = node
            for old in replaced:
                self.supersede(old, by=node)
            self._make_room()
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

    def tours(self, ids):
        """``(N,)`` on which tour the views of nodes were seen, counted from 1; 0: before the first."""
        return self._nodes.tours[self._nodes.rows(ids)]

    def reach(self, ids):
        """``(N, COLUMNS)`` m, how far views went at columns from left to right; 0 where that is not known."""
        return self._nodes.reach[self._nodes.rows(ids)] / np.float32(PER_METRE)

    def scores(self, ids, direction):
        """Scores and bearings ``(N, PER_NODE)`` of the regions of nodes that answer; NaN for regions they lack.

        The score of ``search``, but for the rounding of the direction.
        """
        return self._vectors.scores(self._nodes.ids[self._nodes.rows(ids)], direction)

    def cosines(self, ids, vectors):
        """Cosines ``(N, R)`` of ``vectors (R, D)`` with the regions of nodes that answer, rank by rank."""
        return self._vectors.cosines(self._nodes.ids[self._nodes.rows(ids)], vectors)

    def poses(self, ids):
        """Poses ``(N, 3)`` of nodes, superseded ones too. Raises IndexError for an id that does not exist."""
        return self._nodes.poses[self._nodes.rows(ids)]

    def move(self, ids, poses, covariances=None, grid=None):
        """Corrects the ``poses (N, 3)`` (and covariances (N, 3, 3)) of nodes in place.

        ``grid``: the bytes of the map that fits them, which is kept with them or not at all.

        Raises IndexError for an id that does not exist, and ValueError unless there are as many finite poses, and
        covariances if any. Nothing is changed then.
        """
        rows, poses = self._nodes.rows(ids), np.asarray(poses, float).reshape(-1, 3)
        if len(rows) != len(poses) or not np.isfinite(poses).all():
            raise ValueError(f"{len(rows)} ids need as many finite poses, and {len(poses)} were given")
        if covariances is not None and np.shape(covariances) != (len(rows), 3, 3):
            raise ValueError(f"{len(rows)} ids need covariances ({len(rows)}, 3, 3), not {np.shape(covariances)}")
        with self._writing():
            self._table.move(self._nodes.ids[rows], poses, covariances)
            self._nodes.poses[rows] = poses
            if grid is not None:
                self._keep_map(grid)
            self.flush()

    def supersede(self, node, by=None):
        """``node`` answers no more; its picture stays for audit a while, with the id of the node that replaced it."""
        row = self._nodes.rows(node)
        with self._writing():
            self._table.supersede(node, node if by is None else by)
            self._nodes.answers[row] = False
            self._vectors.forget(node)

    def link(self, i, j, transform=None, information=None, kind="loop"):
        """Adds an edge: the pose of ``j`` seen from ``i`` (default: from their present poses), e.g. a loop closure.

        ``information`` (3, 3) is the inverse covariance, by default that of having driven there.
        """
        (a, b), (i, j) = self.poses([i, j]), (int(i), int(j))
        transform = between(a, b) if transform is None else np.asarray(transform, float)
        information = self.config.motion.information(transform) if information is None else information
        with self._writing():
            self._edges.add(i, j, transform, information, kind)

    def edges(self):
        """All ``Edges``, in the order they were added."""
        return self._edges.all()

    def keyframe(self, node):
        """JPEG bytes of the view of ``node``, or None when none was kept."""
        return self._read("keyframe", node)[0]

    def scan(self, node):
        """The packed scan of ``node`` (see ``scan_bytes``), or None when none was kept."""
        return self._read("scan", node)[0]

    def superseded_by(self, node):
        """Id of the node that replaced ``node`` (its own id when withdrawn by hand), or None while it answers."""
        return self._read("superseded_by", node)[0]

    def view(self, node):
        """What was seen from ``node``: vectors ``(R, D)`` float32 and bearings ``(R,)``; no rows once superseded."""
        return self._vectors.of(node)

    def export(self):
        """What answers queries, to search it elsewhere: owners (M,), int8 (M, D), scales (M,), bearings (M,)."""
        return self._vectors.export()

    def save_map(self, data):
        """Keeps the occupancy map's bytes with the graph, at once: a map is saved when it is worth keeping."""
        with self._writing():
            self._keep_map(data)
            self.flush()

    def load_map(self):
        """The bytes last given to ``save_map``, or None."""
        row = self._db.execute("SELECT data FROM map").fetchone()
        return row and row[0]

    def flush(self):
        """Commits what was added so far."""
        if self._db.in_transaction:
            with self._writing():
                self._db.execute("COMMIT")
        self._pending = 0

    def close(self):
        """Commits and closes the file. The store cannot be used afterwards."""
        self.flush()
        self._db.close()
        self._lock.close()

    def _load(self, first=0):
        """RAM from the file. The next node's id is ``first`` at least."""
        self._vectors, self._nodes = Vectors(self.dim), Nodes(first)
        self._last = None  # id of the node that the next one is linked to; None at the start of a session
        self._pending = 0
        for *node, reach in self._table.all():
            self._nodes.append(*node, 0 if reach is None else np.frombuffer(reach, np.uint8))
        for rows in self._table.vectors(self.dim):
            self._vectors.append(*rows)

    def _candidate(self, pose, vectors):
        """What the gate must know of a view."""
        nodes = self._nodes
        return (
            pose,
            nodes.poses,
            nodes.answers,
            nodes.tours == self._tour,
            lambda rows: self._vectors.cosines(nodes.ids[rows], vectors),
            self.config.gate,
        )

    def _resume(self, old, node, covariance):
        """Links the first node of a session: the map is what it was located in, and ``old`` is what the map is of."""
        (there, here), motion = self.poses([old, node]), self.config.motion
        transform = between(there, here)
        doubt = in_frame(covariance, there[2]) + np.linalg.inv(motion.information(transform))
        self.link(old, node, transform, np.linalg.inv(doubt), kind="session")

    def _make_room(self):
        while len(self) > self.config.limit:
            ids = self.ids
            row = most_redundant(
                self.poses(ids),
                lambda older, newer, ids=ids: self._vectors.likeness(ids[older], ids[newer]),
                self.config.gate,
            )
            self._drop(int(ids[row]))
        superseded = len(self._nodes) - len(self)
        if superseded > self.config.audit:
            for node in self._table.longest_superseded(superseded - self.config.audit):
                self._drop(node)

    def _drop(self, node):
        """``node`` is gone, from RAM and file; what it was linked to is linked past it."""
        self._edges.bypass(node)
        self._table.drop(node)
        self._vectors.forget(node)
        self._nodes.drop(node)

    def _meta(self, key):
        row = self._db.execute("SELECT value FROM meta WHERE key=?", (key,)).fetchone()
        return row and row[0]

    def _keep_map(self, data):
        self._db.execute("INSERT OR REPLACE INTO map VALUES (0, ?)", (data,))

    def _note(self, key, value):
        with self._writing():
            self._db.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, value))
            self.flush()

    @contextmanager
    def _writing(self):
        """Within the open transaction, or a new one. When it fails, as on a full disk, RAM holds what the file does."""
        try:
            if not self._db.in_transaction:
                self._db.execute("BEGIN")
            yield
        except sqlite3.Error:
            if self._db.in_transaction:
                self._db.execute("ROLLBACK")
            self._load(self._nodes.next)
            raise

    def _read(self, column, ids):
        """What the file has in ``column`` for nodes, a list."""
        return self._table.read(column, self._nodes.ids[self._nodes.rows(ids)].tolist())
