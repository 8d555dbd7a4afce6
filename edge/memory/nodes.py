"""The nodes of the graph in RAM: their poses, which of them answer queries, and on which tour they were seen."""

import numpy as np

from edge.memory.vectors import grown
from edge.pose import wrap

COLUMNS = 32  # of the picture, for which a node knows how far it saw; 2.5 degrees each
PER_METRE = 32  # steps of a reach, which is one byte: 3 cm, up to 8 m


class Nodes:
    """Rows in ascending order of ids. Ids are never given twice; a node that is dropped leaves a gap in them."""

    def __init__(self, first=0):
        """``first``: the least id that may be given."""
        self._first = first
        self._count = 0
        self._ids = np.empty(0, np.int64)
        self._poses = np.empty((0, 3))
        self._answers = np.empty(0, bool)
        self._tours = np.empty(0, np.int32)
        self._reach = np.empty((0, COLUMNS), np.uint8)

    def __len__(self):
        return self._count

    @property
    def nbytes(self):
        """Bytes held in RAM, spare capacity included."""
        return sum(a.nbytes for a in (self._ids, self._poses, self._answers, self._tours, self._reach))

    @property
    def ids(self):
        """Ids ``(N,)`` int64 of all nodes; a view."""
        return self._ids[: self._count]

    @property
    def poses(self):
        """Poses ``(N, 3)``; a view."""
        return self._poses[: self._count]

    @property
    def answers(self):
        """``(N,)`` bool, False for superseded nodes; a view."""
        return self._answers[: self._count]

    @property
    def tours(self):
        """``(N,)`` int32; a view."""
        return self._tours[: self._count]

    @property
    def reach(self):
        """``(N, COLUMNS)`` uint8 in steps of 1 / PER_METRE m, left to right; 0 where it is not known; a view."""
        return self._reach[: self._count]

    @property
    def next(self):
        """The id of the next node."""
        return max(self._first, int(self._ids[self._count - 1]) + 1 if self._count else 0)

    def append(self, node, pose, answers, tour, reach):
        """Adds ``node``, whose id is larger than all others."""
        self._ids = grown(self._ids, self._count + 1)
        self._poses = grown(self._poses, self._count + 1)
        self._answers = grown(self._answers, self._count + 1)
        self._tours = grown(self._tours, self._count + 1)
        self._reach = grown(self._reach, self._count + 1)
        row = self._count
        self._ids[row], self._poses[row], self._answers[row], self._tours[row] = node, pose, answers, tour
        self._reach[row] = reach
        self._count += 1

    def drop(self, node):
        """Forgets ``node``."""
        row = int(self.rows(node)[0])
        for array in (self._ids, self._poses, self._answers, self._tours, self._reach):
            array[row : self._count - 1] = array[row + 1 : self._count]
        self._count -= 1

    def nearest(self, pose, gate):
        """Id of the node nearest to ``pose (3,)``, by what the ``gate`` takes for another place; None without nodes."""
        if not self._count:
            return None
        away = self.poses - pose
        turned = np.abs(wrap(away[:, 2])) / gate.angle
        return int(self.ids[(np.hypot(away[:, 0], away[:, 1]) / gate.distance + turned).argmin()])

    def rows(self, ids):
        """Rows ``(M,)`` of nodes with these ids. Raises IndexError for one that does not exist."""
        ids = np.atleast_1d(np.asarray(ids, np.int64))
        rows = np.searchsorted(self.ids, ids)
        known = rows < self._count
        known[known] = self.ids[rows[known]] == ids[known]
        if not known.all():
            has = f"has nodes {self.ids[0]} to {self.ids[-1]}" if self._count else "has no nodes"
            raise IndexError(f"the store {has}, and {ids[~known][0]} is none of them")
        return rows
