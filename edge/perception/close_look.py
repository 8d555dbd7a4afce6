"""A closer look at a picture: the whole of it, then windows of it, each through the image tower by itself.

A whole-picture vector hides small things ([V] leaves it at that). A thing that spans a tenth of the picture spans a
fifth of a window. It costs a pass a window, so it is for the views that count: those that become nodes, and those that
decide whether the object is there.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from edge.camera import CameraModel
from edge.perception.encoder import View

# Left, top, right, bottom as shares of the picture: halves that overlap. Above 3/8 of the height, a level camera
# 0.88 m high sees only walls from 1.5 m on.
WINDOWS = ((0.0, 0.375, 0.5, 1.0), (0.25, 0.375, 0.75, 1.0), (0.5, 0.375, 1.0, 1.0))


def look_closely(encoder, rgb: np.ndarray, whole: View | None = None, hfov: float = CameraModel.hfov) -> Iterator[View]:
    """Views of RGB ``(H, W, 3)``: the ``whole`` (encoded unless given), then the windows from left to right.

    One at a time: with its maps a view takes 0.6 MB, which few need of more than one.
    """
    height, width = rgb.shape[:2]
    sizes = np.array([width, height, width, height])
    parts = [tuple(np.rint(window * sizes).astype(int).tolist()) for window in np.array(WINDOWS)]
    yield whole or encoder.encode_image(rgb, hfov)
    for window in parts:
        yield encoder.encode_image(rgb, hfov, window)


def window_at(centre: tuple[float, float], width: int, height: int) -> tuple[int, int, int, int]:
    """The window, of the size that ``WINDOWS`` have, around pixel ``centre`` (u, v): a fovea that follows."""
    left, top, right, bottom = np.rint(np.array(WINDOWS[0]) * (width, height, width, height)).astype(int).tolist()
    size = np.array([right - left, bottom - top])
    corner = np.clip(np.rint(centre).astype(int) - size // 2, 0, (width, height) - size)
    return tuple(np.concatenate([corner, corner + size]).tolist())


def to_remember(views: Iterable[View]) -> tuple[np.ndarray, np.ndarray]:
    """One vector a view, ``(R, D)``, and its bearing, ``(R,)`` [rad]: what a node keeps of a closer look."""
    vectors, bearings = zip(*((view.vectors[0], view.bearings[0]) for view in views))
    return np.stack(vectors), np.array(bearings)
