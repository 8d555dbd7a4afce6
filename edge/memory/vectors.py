"""int8 embeddings in one contiguous matrix, searched exactly.

A home holds a few thousand vectors, and an exact int8 scan of 20 000 takes under a millisecond, so there is no index:
nothing to build, to tune, or to keep in memory beside the vectors themselves.
"""

from math import isfinite
from typing import NamedTuple

import numkong
import numpy as np

from edge.memory.database import PER_NODE

_FIRST_ROWS = 64
_SPARE = 8  # rows scored again beyond those asked for and a quarter of them
_FOLDS = 16  # values of which one stands for all while the least of the largest is sought
_SLACK = 8  # the matrix grows by 1/8: enough to amortise the copies, little enough to stay under 1.5 x the embedding


class Hits(NamedTuple):
    """Answer of a search, best first; one hit per (node, region)."""

    ids: np.ndarray  # (K,) int64 node ids; a node with several matching regions appears several times
    scores: np.ndarray  # (K,) float32 dot products with the query direction
    bearings: np.ndarray  # (K,) float32 bearing [rad] of the region from the robot's heading, left positive


def quantize(vectors):
    """Rows ``(N, D)`` to int8 ``(N, D)`` and float32 ``(N,)`` scales: ``int8 * scale`` is the row within scale / 2.

    Symmetric, one scale a row: the largest magnitude of the row becomes 127.
    """
    vectors = np.atleast_2d(np.asarray(vectors, np.float32))
    scales = np.abs(vectors).max(axis=1) / np.float32(127)
    safe = np.where(scales > 0, scales, np.float32(1))
    return np.rint(vectors / safe[:, None]).astype(np.int8), scales.astype(np.float32)


def grown(array, rows):
    """``array`` itself when it has ``rows`` rows, else resized in place with 1/8 to spare. Keep no views of it."""
    if rows > len(array):
        rows = max(_FIRST_ROWS, rows + rows // _SLACK)
        array.resize((rows, *array.shape[1:]), refcheck=False)
    return array


class Vectors:
    """Append-only rows of int8, each with its scale, the node it belongs to and its bearing."""

    def __init__(self, dim):
        """``dim``: components of a vector, at least 1."""
        self.dim = dim
        self._count = 0
        self._dead = 0
        self._matrix = np.empty((0, dim), np.int8)
        self._scales = np.empty(0, np.float32)
        self._owners = np.empty(0, np.int32)  # node ids, ascending
        self._answers = np.empty(0, bool)  # False once forgotten
        self._bearings = np.empty(0, np.float32)

    def __len__(self):
        """Number of rows that answer a search."""
        return self._count - self._dead

    @property
    def nbytes(self):
        """Bytes held in RAM, spare capacity included."""
        return sum(a.nbytes for a in (self._matrix, self._scales, self._owners, self._answers, self._bearings))

    def append(self, owners, matrix, scales, bearings):
        """Adds quantised rows ``(M, D)``; ``owners`` is one node id, or one for each row, and ids never descend."""
        start, stop = self._count, self._count + len(matrix)
        self._matrix = grown(self._matrix, stop)
        self._scales = grown(self._scales, stop)
        self._owners = grown(self._owners, stop)
        self._answers = grown(self._answers, stop)
        self._bearings = grown(self._bearings, stop)
        self._matrix[start:stop] = matrix
        self._scales[start:stop] = scales
        self._owners[start:stop] = owners
        self._answers[start:stop] = True
        self._bearings[start:stop] = bearings
        self._count = stop

    def forget(self, node):
        """The rows of ``node`` answer no more. Their memory is taken back when an eighth of all rows is forgotten."""
        rows = self._rows(node)
        self._dead += int(self._answers[rows].sum())
        self._answers[rows] = False
        if self._dead > max(_FIRST_ROWS, self._count // _SLACK):
            self._compact()

    def search(self, direction, k):
        """The ``k`` rows with the largest dot product with ``direction (D,)`` float: ``Hits``, best first.

        The int8 scan proposes a few more rows; these are scored again with the unquantised direction, so that the
        query's own rounding, a thousandth of a unit vector's score, moves neither the order nor the scores. An empty
        memory or ``k`` = 0 gives empty hits.
        """
        direction = np.asarray(direction, np.float32)
        if direction.shape != (self.dim,):
            raise ValueError(f"the query has shape {direction.shape}, and the store holds vectors of {self.dim}")
        peak = float(np.abs(direction).max())
        if not isfinite(peak):
            raise ValueError("the query direction holds NaN or infinity; encode the text again")
        k = min(k, len(self))
        if k <= 0:
            return Hits(np.empty(0, np.int64), np.empty(0, np.float32), np.empty(0, np.float32))
        coarse, _ = self._dots(direction, peak)
        if self._dead:
            coarse[~self._answers[: self._count]] = -np.inf
        rows = largest(coarse, min(k + k // 4 + _SPARE, len(self)))
        scores = (self._matrix.take(rows, axis=0).astype(np.float32) @ direction) * self._scales[rows]
        best = (-scores).argsort(kind="stable")[:k]
        rows = rows[best]
        return Hits(self._owners[rows].astype(np.int64), scores[best], self._bearings[rows])

    def scores(self, nodes, direction):
        """Scores and bearings ``(M, PER_NODE)`` of the regions of ``nodes (M,)``; NaN where a node has none."""
        rows, has = self._of_rank(nodes, np.arange(PER_NODE))
        direction = np.asarray(direction, np.float32)
        dots, scale = self._dots(direction, float(np.abs(direction).max()))
        return np.where(has, dots[rows] * scale, np.nan), np.where(has, self._bearings[rows], np.nan)

    def cosines(self, nodes, vectors):
        """Cosines ``(M, R)`` of the rows of ``vectors (R, D)`` with the regions of ``nodes (M,)``, rank by rank.

        NaN where a node has no region of that rank. The nodes must not have been forgotten.
        """
        given = np.asarray(vectors, np.float32)
        rows, has = self._of_rank(nodes, np.arange(len(given)))
        regions = self._matrix[rows].astype(np.float32)
        norms = np.sqrt(np.einsum("mrd,mrd->mr", regions, regions)) * np.linalg.norm(given, axis=1)
        cosines = np.einsum("mrd,rd->mr", regions, given) / np.maximum(norms, np.float32(1e-12))
        return np.where(has, cosines, np.float32(np.nan))

    def likeness(self, nodes, others):
        """Cosines ``(M,)`` of the least similar region of ``nodes (M,)`` and ``others (M,)``, rank by rank.

        A thing that only one region shows tells two views apart. Ranks that one of the two lacks do not count.
        """
        least = np.full(len(nodes), np.inf, np.float32)
        for rank in range(PER_NODE):
            (rows, has), (other_rows, others_have) = (self._of_rank(given, [rank]) for given in (nodes, others))
            both = (has & others_have)[:, 0]
            a, b = self._matrix[rows[both, 0]], self._matrix[other_rows[both, 0]]
            dots, of_a, of_b = (np.einsum("md,md->m", *pair, dtype=np.int32) for pair in ((a, b), (a, a), (b, b)))
            least[both] = np.minimum(least[both], dots / np.sqrt(np.maximum(of_a.astype(np.float32) * of_b, 1)))
        return least

    def of(self, node):
        """The regions of ``node``: vectors ``(R, D)`` float32 and bearings ``(R,)`` [rad]; no rows once forgotten."""
        rows = self._rows(node)
        rows = slice(rows.start, rows.stop if self._answers[rows].all() else rows.start)
        return self._matrix[rows] * self._scales[rows, None], self._bearings[rows].copy()

    def export(self):
        """Rows that answer: owners ``(M,)`` int32, matrix ``(M, D)`` int8, scales ``(M,)``, bearings ``(M,)``."""
        alive = self._answers[: self._count]
        return tuple(a[: self._count][alive] for a in (self._owners, self._matrix, self._scales, self._bearings))

    def _dots(self, direction, peak):
        """Dot products ``(N,)`` float32 of all rows with ``direction (D,)`` in int8, and the scale that they lack.

        ``peak`` is the greatest magnitude in ``direction``.
        """
        scale = max(peak, 1e-30) / 127
        query = np.rint(direction * np.float32(1 / scale)).astype(np.int8)
        dots = np.asarray(numkong.cdist(query[None], self._matrix[: self._count], "dot", out_dtype="f32"))[0]
        dots *= self._scales[: self._count]
        return dots, np.float32(scale)

    def _of_rank(self, nodes, ranks):
        """Rows ``(M, R)`` of the regions of ``ranks (R,)`` of ``nodes (M,)``, and whether each node has them."""
        owners = self._owners[: self._count]
        rows = np.searchsorted(owners, nodes)[:, None] + np.asarray(ranks)
        has = rows < self._count
        rows = np.where(has, rows, 0)
        return rows, has & (owners[rows] == np.asarray(nodes)[:, None])

    def _rows(self, node):
        owners = self._owners[: self._count]
        return slice(int(np.searchsorted(owners, node)), int(np.searchsorted(owners, node, side="right")))

    def _compact(self):
        alive = self._answers[: self._count].copy()
        kept = int(alive.sum())
        for array in (self._matrix, self._scales, self._owners, self._bearings, self._answers):
            array[:kept] = array[: self._count][alive]
        self._count, self._dead = kept, 0


def largest(values, k):
    """Indices of the ``k`` largest of ``values``, largest first; of equal ones, the first.

    Of every ``_FOLDS`` values the largest is kept; at least ``k`` values reach the k-th largest of those, and few more.
    That leaves a sixteenth to be partitioned, which was a fifth of a search. Values that follow each other, as those of
    one place do, are kept apart.
    """
    width = len(values) // _FOLDS
    folded = values[: _FOLDS * width].reshape(_FOLDS, width).max(axis=0) if width >= k else values
    least = np.partition(folded, len(folded) - k)[len(folded) - k]
    rows = np.flatnonzero(values >= least)
    return rows[(-values[rows]).argsort(kind="stable")[:k]]
