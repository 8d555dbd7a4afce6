"""The host's copy of a robot's memory: what it has seen from where, searchable while the robot is busy or asleep."""

import numpy as np

from edge.link.requests import GraphReply
from edge.memory.vectors import Hits, Vectors


class Replica:
    """Follows the graph of one robot, fetching only what is new."""

    def __init__(self, dim, memory):
        """``memory``: the id of the memory that is copied."""
        self.memory = memory
        self._vectors = Vectors(dim)
        self._dim = dim
        self._poses = {}  # node id -> (3,)

    def __len__(self):
        return len(self._poses)

    @property
    def next(self):
        """The first node id that the copy does not have: what to ask the robot for."""
        return max(self._poses, default=-1) + 1

    def update(self, graph: GraphReply):
        """Takes in a reply that holds the vectors from ``next`` on, and the poses of all nodes that still answer.

        Raises ValueError when its arrays do not fit together.
        """
        ids, poses, new = graph.ids.numpy(), graph.poses.numpy(), graph.vectors
        owners, matrix = new.owners.numpy(), new.data.numpy()
        scales, bearings = new.scales.numpy(), new.bearings.numpy()
        if poses.shape != (len(ids), 3) or matrix.shape != (len(owners), self._dim):
            raise ValueError(f"the robot sent poses {poses.shape} for {len(ids)} nodes and vectors {matrix.shape}")
        if scales.shape != owners.shape or bearings.shape != owners.shape:
            raise ValueError(f"the robot sent {len(scales)} scales, {len(bearings)} bearings, {len(owners)} vectors")
        for node in self._poses.keys() - set(ids.tolist()):
            self._vectors.forget(node)
        fresh = owners >= self.next
        self._vectors.append(owners[fresh], matrix[fresh], scales[fresh], bearings[fresh])
        self._poses = dict(zip(ids.tolist(), poses, strict=True))

    def search(self, direction, k) -> tuple[Hits, np.ndarray]:
        """Hits of ``direction (D,)``, best first, and the poses ``(K, 3)`` of their nodes."""
        hits = self._vectors.search(direction, k)
        return hits, np.array([self._poses[node] for node in hits.ids.tolist()]).reshape(-1, 3)
