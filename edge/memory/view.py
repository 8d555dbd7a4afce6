"""A view as it is offered to the memory, checked."""

from typing import NamedTuple

import numpy as np

from edge.memory.database import PER_NODE
from edge.memory.nodes import COLUMNS, PER_METRE


class View(NamedTuple):
    """See ``Vlpg.add``."""

    pose: np.ndarray  # (3,)
    covariance: np.ndarray  # (3, 3)
    vectors: np.ndarray  # (R, D) float32
    bearings: np.ndarray  # (R,)
    reach: np.ndarray  # (COLUMNS,) uint8 in steps of 1 / PER_METRE m

    @classmethod
    def checked(cls, dim, pose, covariance, vectors, bearings, reach):
        """Raises ValueError for wrong shapes or numbers that are not finite."""
        pose, covariance = np.asarray(pose, float), np.asarray(covariance, float)
        vectors, bearings = np.atleast_2d(np.asarray(vectors, np.float32)), np.atleast_1d(np.asarray(bearings, float))
        reach = np.zeros(COLUMNS) if reach is None else np.asarray(reach, float)
        if pose.shape != (3,) or covariance.shape != (3, 3):
            raise ValueError(f"pose must be (3,) and covariance (3, 3), not {pose.shape} and {covariance.shape}")
        if vectors.ndim != 2 or vectors.shape[1] != dim or not 1 <= len(vectors) <= PER_NODE:
            raise ValueError(f"vectors must be (1 to {PER_NODE}, {dim}), not {vectors.shape}")
        if bearings.shape != (len(vectors),):
            raise ValueError(f"{len(vectors)} vectors need as many bearings, not {bearings.shape}")
        if reach.shape != (COLUMNS,):
            raise ValueError(f"reach must be ({COLUMNS},), not {reach.shape}")
        if not all(np.isfinite(a).all() for a in (pose, covariance, vectors, bearings, reach)):
            raise ValueError("a view with NaN or infinity in any of its numbers cannot be stored")
        steps = np.clip(np.rint(reach * PER_METRE), 0, 255).astype(np.uint8)
        return cls(pose, covariance, vectors, bearings, steps)
