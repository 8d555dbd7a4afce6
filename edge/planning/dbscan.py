"""Density-based clustering (Ester, Kriegel, Sander, Xu 1996), for the few hundred points that a query returns."""

import numpy as np

NOISE = -1


def dbscan(points: np.ndarray, radius: float, min_points: int) -> np.ndarray:
    """Cluster labels ``(N,)`` int of ``points (N, D)``: 0, 1, … in order of each cluster's first core point.

    A core point has at least ``min_points`` points, itself included, within ``radius``. A point near core points of
    several clusters joins the first of them; a point near none is ``NOISE``. Needs N² bytes.
    """
    points = np.asarray(points, float)
    labels = np.full(len(points), NOISE)
    near = np.empty((len(points), len(points)), bool)
    for i, point in enumerate(points):  # row by row, so that no (N, N, D) array is ever made
        difference = points - point
        near[i] = np.einsum("nd,nd->n", difference, difference) <= radius * radius
    core = near.sum(axis=1) >= min_points
    cluster = 0
    for seed in np.flatnonzero(core):
        if labels[seed] != NOISE:
            continue
        front = np.array([seed])
        while len(front):
            labels[front] = cluster
            front = np.flatnonzero(near[front[core[front]]].any(axis=0) & (labels == NOISE))
        cluster += 1
    return labels
