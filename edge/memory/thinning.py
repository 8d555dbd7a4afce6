"""Which node makes room when the store is full."""

from math import pi

import numpy as np


def most_redundant(poses, likeness, gate):
    """Row of the node that is missed least: one of the fullest place, whose like was seen from there again later.

    A place is a position and a heading, as far as the gate tells two of them apart. The last view of a place stays as
    long as any other place has two; when none has, places are taken twice as wide. So a full store thins out evenly,
    and what it held before is still seen from somewhere near.

    Args:
        poses: (N, 3) of the nodes that answer, oldest first; N at least 2.
        likeness: rows (P,), rows (P,) -> cosines (P,) of what pairs of nodes saw.
        gate: GateConfig.
    """
    corner = poses[:, :2].min(axis=0)
    steps = np.array([gate.distance, gate.distance, gate.angle])
    cells = np.column_stack([poses[:, :2] - corner, poses[:, 2] % (2 * pi)])
    while True:
        column, row, heading = np.floor(cells / steps).astype(np.int64).T
        places = (column * (row.max() + 1) + row) * (heading.max() + 1) + heading
        _, place, crowd = np.unique(places, return_inverse=True, return_counts=True)
        if crowd.max() > 1:
            break
        steps = 2 * steps
    order = np.argsort(place, kind="stable")  # place by place, oldest first
    order = order[crowd[place[order]] == crowd.max()]
    older, newer = order[:-1], order[1:]
    same = place[older] == place[newer]
    older, newer = older[same], newer[same]
    return int(older[likeness(older, newer).argmax()])
