"""Many straight rays drawn into a grid mask by one call."""

import cv2
import numpy as np

_SHIFT = 8  # fractional bits of the fixed-point pixel coordinates that OpenCV draws with: 1/256 cell


def _pixels(xy: np.ndarray) -> np.ndarray:
    """Coordinates ``(..., 2)`` [cells] in OpenCV's fixed point, where whole numbers are the centres of cells."""
    return np.rint((np.asarray(xy) - 0.5) * (1 << _SHIFT)).astype(np.int32)


def draw_rays(mask: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> None:
    """Sets to 1 the cells of ``mask`` (H, W) uint8 on segments ``starts`` to ``ends``, each ``(N, 2)`` x, y [cells].

    Coordinates are cells from the lower-left corner of cell [0, 0]. A ray takes one cell for each step along its
    longer axis, all of them cells that the segment really crosses (tested against a supercover line).
    """
    if len(ends):
        segments = _pixels(np.stack(np.broadcast_arrays(starts, ends), axis=1))
        cv2.polylines(mask, segments, False, 1, 1, cv2.LINE_8, _SHIFT)


def fill_fan(mask: np.ndarray, apex: np.ndarray, directions: np.ndarray, lengths: np.ndarray) -> None:
    """Sets to 1 the cells of ``mask`` between neighbouring beams of a full turn, as far as the shorter of the two.

    ``apex`` (2,) [cells], ``directions`` (N, 2) unit vectors in turning order, ``lengths`` (N,) [cells].
    """
    shared = np.minimum(lengths, np.roll(lengths, -1))[:, None]
    corners = np.stack([directions * shared, np.roll(directions, -1, axis=0) * shared], axis=1).reshape(-1, 2)
    cv2.fillPoly(mask, [_pixels(apex + corners)], 1, cv2.LINE_8, _SHIFT)
