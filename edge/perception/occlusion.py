"""Whether something stands before what a picture shows."""

import cv2
import numpy as np

from edge.perception.detection import Detection

NEARER = 0.3  # m by which it must be nearer than the target where the two meet; less is the target's own shape
MARGIN = 4  # px on either side of the outline; a depth camera smears edges over two
_AROUND = np.ones((2 * MARGIN + 1, 2 * MARGIN + 1), np.uint8)


def hidden_share(detection: Detection, depth) -> float:
    """Share of the target's outline, in [0, 1], at which something nearer begins, by ``depth (H, W)`` [m].

    The picture's border hides nothing: it does not count.
    """
    x0, y0, x1, y1 = (int(edge) for edge in detection.box)
    left, top = max(x0 - MARGIN, 0), max(y0 - MARGIN, 0)
    part = depth[top : y1 + MARGIN, left : x1 + MARGIN]
    mask = np.zeros(part.shape, bool)
    inside = mask[y0 - top : y1 - top, x0 - left : x1 - left]
    inside[:] = detection.mask[: inside.shape[0], : inside.shape[1]]
    # Each pixel of the outline is compared with the target beside it: a couch seen along its length is at many depths.
    # The farthest there, as the edge of what is nearer is smeared over it.
    own = cv2.dilate(np.where(mask, part, 0.0).astype(np.float32), _AROUND)
    outline = cv2.dilate(mask.view(np.uint8), _AROUND).view(bool) & ~mask
    if not outline.any():
        return 0.0
    return float((part < own - NEARER)[outline].mean())
