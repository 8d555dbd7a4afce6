"""Move a map along with the nodes of the graph it was made from."""

import cv2
import numpy as np

from edge.mapping.grid import GridFrame
from edge.pose import between, compose

LATTICE = 8  # cells between the points whose displacement is computed; it is smooth, the rest is interpolated
WIDTH = 1.0  # m over which the corrections of neighbouring nodes blend
CHUNK = 64  # points carried at once: all of a long path times all nodes would take hundreds of megabytes


def sources(frame: GridFrame, before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Column and row (float32, ``frame.shape``) in the old map of what each cell of the moved map shows.

    ``before`` and ``after`` (N, 3) are the nodes' poses. Each point moves with the nodes around it, rigidly where they
    agree, weighted by a Gaussian of their distance.
    """
    rows, cols = (np.arange(0, size + LATTICE, LATTICE) for size in frame.shape)
    lattice = np.meshgrid(rows, cols, indexing="ij")
    points = frame.to_world(*(index.ravel() for index in lattice))
    shift = ((carried(points, after, before) - points) / frame.resolution).astype(np.float32)
    shift = shift.reshape(len(rows), len(cols), 2)
    height, width = frame.shape
    col, row = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    moved = cv2.remap(shift, col / LATTICE, row / LATTICE, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return col + moved[..., 0], row + moved[..., 1]


def carried(points: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Where ``points`` (P, 2) go when the nodes around them move from ``before`` to ``after`` (N, 3)."""
    there = [_carried(points[start : start + CHUNK], before, after) for start in range(0, len(points), CHUNK)]
    return np.concatenate([np.empty((0, 2)), *there])


def _carried(points, before, after):
    poses = np.column_stack([points, np.zeros(len(points))])[:, None]
    moved = compose(after, between(before, poses))[..., :2]  # (P, N, 2): taken along by each node
    distance = np.hypot(*np.moveaxis(points[:, None] - before[:, :2], -1, 0))
    distance -= distance.min(1, keepdims=True)  # far from all nodes, the nearest one decides
    weight = np.exp(-0.5 * (distance / WIDTH) ** 2)
    return (weight[..., None] * moved).sum(1) / weight.sum(1, keepdims=True)


def carried_pose(pose: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Where a pose (3,) goes, like ``carried``; its heading is that of two points on it."""
    ahead = pose[:2] + 0.2 * np.array([np.cos(pose[2]), np.sin(pose[2])])
    here, there = carried(np.stack([pose[:2], ahead]), before, after)
    return np.array([*here, np.arctan2(there[1] - here[1], there[0] - here[0])])


def warped(layer: np.ndarray, column: np.ndarray, row: np.ndarray) -> np.ndarray:
    """A layer (H, W) of the map moved by ``sources``; 0, unknown, where it comes from outside."""
    return cv2.remap(layer.view(np.uint8), column, row, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT).view(
        layer.dtype
    )
