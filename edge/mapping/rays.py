"""Many straight rays drawn into a grid mask by one call."""

import cv2
import numpy as np


def draw_rays(mask: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> None:
    """Sets to 1 the cells of ``mask`` (H, W) uint8 on segments ``starts`` to ``ends``, each ``(N, 2)`` x, y [cells].

    Coordinates are cells from the lower-left corner of cell [0, 0]. A ray runs from the middle of its first cell to
    the middle of its last (Bresenham 1965), as grid mapping commonly does: it is at most half a cell off.
    """
    if len(ends):
        segments = np.stack(np.broadcast_arrays(starts, ends), axis=1)
        cv2.polylines(mask, np.floor(segments).astype(np.int32), False, 1)


def fill_fan(mask: np.ndarray, apex: np.ndarray, directions: np.ndarray, lengths: np.ndarray) -> None:
    """Sets to 1 the cells of ``mask`` between neighbouring beams of a full turn, as far as the shorter of the two.

    ``apex`` (2,) [cells], ``directions`` (N, 2) unit vectors in turning order, ``lengths`` (N,) [cells].
    """
    shared = np.minimum(lengths, np.roll(lengths, -1))[:, None]
    corners = np.stack([directions * shared, np.roll(directions, -1, axis=0) * shared], axis=1).reshape(-1, 2)
    cv2.fillPoly(mask, [np.floor(apex + corners).astype(np.int32)], 1)
