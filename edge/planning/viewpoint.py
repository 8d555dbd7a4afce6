"""From the poses that a query returns to ranked viewpoints: [V] Sec. III-C, DBSCAN and Eq. 3."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil
from typing import Literal

import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.planning.dbscan import NOISE, dbscan


@dataclass(frozen=True)
class ViewpointConfig:
    """Clustering of hits and the order of the clusters. [V] gives no values."""

    cluster_radius: float = 0.75  # in (x [m], y [m], cos θ, sin θ); 44° of turn count as much as 0.75 m
    cluster_size: int = 3  # hits within the radius, itself included, that make a core point
    # "size" is the paper's: most members first, ties by mean score. "evidence" weighs each member by its score, so that
    # many weak hits, of which the top k are never short, do not beat a few strong ones.
    ranking: Literal["evidence", "size"] = "evidence"
    temperature: float = 0.10  # score difference that changes a hit's weight e-fold
    # Members whose score is no further below their best one's choose the pose (Eq. 3); the paper lets all of them. A
    # query has k hits, whether or not so many views show the object, and weak ones outnumber those that do.
    strong: float = 0.3


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """Where to look from, and why."""

    pose: np.ndarray  # (3,) the strong member whose field of view overlaps most with the others', map frame
    score: float  # mean score of the members
    members: np.ndarray  # (M,) int indices into the hits, best score first
    support: float  # sum of the members' weights, each in (0, 1]; 1 is the weight of the query's best hit


@lru_cache(maxsize=2)
def _rays(camera: CameraModel, resolution: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Sample points ``(rays, steps)`` x and y [m] in base_link, and how many steps lie nearer than the minimum depth.

    Rays are 0.7 cells apart at full range and sampled every half cell: no cell in view falls between them.
    """
    count = ceil(camera.hfov * camera.max_depth / (0.7 * resolution)) + 1
    angle = np.linspace(-camera.hfov / 2, camera.hfov / 2, count, dtype=np.float32)[:, None]
    distance = np.arange(resolution / 2, camera.max_depth, resolution / 2, dtype=np.float32)
    blind = int(np.searchsorted(distance, camera.min_depth))
    return camera.ahead + distance * np.cos(angle), camera.left + distance * np.sin(angle), blind


def visible_cells(occupied: np.ndarray, frame: GridFrame, pose, camera: CameraModel) -> np.ndarray:
    """Sorted flat indices ``(N,)`` of the cells in the camera's field of view from ``pose (3,)``.

    Rays stop at the first occupied cell, which counts as seen, and do not slip between two occupied cells that touch
    at a corner. The field reaches from ``min_depth`` to ``max_depth`` around the camera (79°, 0.5–5 m in [V]).
    """
    rows, cols = occupied.shape
    x, y, blind = _rays(camera, frame.resolution)
    cos, sin = np.float32(np.cos(pose[2])), np.float32(np.sin(pose[2]))
    scale = np.float32(1.0 / frame.resolution)
    col0 = np.float32((pose[0] - frame.origin[0]) / frame.resolution + 1)  # + 1: the padding below
    row0 = np.float32((pose[1] - frame.origin[1]) / frame.resolution + 1)
    col = np.clip((x * cos - y * sin) * scale + col0, 0, cols + 1).astype(np.int32)
    row = np.clip((x * sin + y * cos) * scale + row0, 0, rows + 1).astype(np.int32)
    width = cols + 2
    solid = np.ones((rows + 2, width), bool)  # what is outside the grid is never seen
    solid[1:-1, 1:-1] = occupied
    solid = solid.ravel()
    flat = row * width + col
    hit = solid[flat]
    jump = np.diff(flat, axis=1)
    ray, step = np.nonzero((np.abs(jump) > 1) & (np.abs(jump) != width))  # both the row and the column change
    side_a = row[ray, step] * width + col[ray, step + 1]
    side_b = row[ray, step + 1] * width + col[ray, step]
    closed = solid[side_a] & solid[side_b]
    ray, step = ray[closed], step[closed] + 1
    hit[ray, step] = True
    flat[ray, step] = side_a[closed]  # then it is the corner's cell that is seen
    end = np.where(hit.any(axis=1), hit.argmax(axis=1), hit.shape[1])
    steps = np.arange(hit.shape[1])
    seen = np.zeros(solid.size, bool)
    seen[flat[(steps >= blind) & (steps <= end[:, None])]] = True
    return np.flatnonzero(seen.reshape(rows + 2, width)[1:-1, 1:-1])


def rank_viewpoints(
    poses: np.ndarray,
    scores: np.ndarray,
    occupied: np.ndarray,
    frame: GridFrame,
    camera: CameraModel,
    config: ViewpointConfig = ViewpointConfig(),
) -> list[Viewpoint]:
    """One viewpoint for each cluster of the hits, the most promising first.

    ``poses (N, 3)`` look at the hits (map frame), ``scores (N,)`` are Eq. 2's, in [0, 1]. [V] keeps the largest cluster
    only; here all stay as ranked hypotheses, and a hit outside every cluster is one of its own.
    """
    poses, scores = np.asarray(poses, float).reshape(-1, 3), np.asarray(scores, float)
    if len(poses) == 0:
        return []
    features = np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    labels = dbscan(features, config.cluster_radius, config.cluster_size)
    groups = [np.flatnonzero(labels == label) for label in range(labels.max() + 1)]
    groups += [np.array([i]) for i in np.flatnonzero(labels == NOISE)]
    weights = np.exp((scores - scores.max()) / config.temperature)
    viewpoints = []
    for group in groups:
        group = group[np.argsort(-scores[group], kind="stable")]
        strong = group[scores[group] >= scores[group[0]] - config.strong]
        best = strong[_most_overlapping(poses[strong], occupied, frame, camera)]
        viewpoints.append(Viewpoint(poses[best], float(scores[group].mean()), group, float(weights[group].sum())))
    if config.ranking == "size":
        return sorted(viewpoints, key=lambda v: (-len(v.members), -v.score))
    return sorted(viewpoints, key=lambda v: (-v.support, -v.score))


def _most_overlapping(poses: np.ndarray, occupied: np.ndarray, frame: GridFrame, camera: CameraModel) -> int:
    """Eq. 3: index of the pose that shares most cells of its field of view with the union of the others'."""
    if len(poses) == 1:
        return 0
    fields = [visible_cells(occupied, frame, pose, camera) for pose in poses]
    views = np.zeros(occupied.size, np.int32)
    for field in fields:
        views[field] += 1
    return int(np.argmax([np.count_nonzero(views[field] > 1) for field in fields]))
