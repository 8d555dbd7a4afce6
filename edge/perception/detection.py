"""Where in the picture the target is: two-prompt score, Grad-CAM, largest component ([V] Sec. III-C)."""

from dataclasses import dataclass

import cv2
import numpy as np

from edge.perception.encoder import Encoder, View
from edge.perception.prompts import Target


@dataclass(frozen=True, eq=False)
class Detection:
    """``box`` (x0, y0, x1, y1) px, float, of the picture's own size; ``score`` in [0, 1], the two-prompt score.

    ``mask`` (y1 - y0, x1 - x0) bool: which of the box's pixels are the target's.
    """

    box: tuple[float, float, float, float]
    score: float
    mask: np.ndarray

    @property
    def centre(self) -> tuple[float, float]:
        """(u, v) px. The box has the outer edges of pixels, which have their own centres at whole numbers."""
        x0, y0, x1, y1 = self.box
        return (x0 + x1 - 1) / 2, (y0 + y1 - 1) / 2


@dataclass(frozen=True)
class DetectorConfig:
    """When a target counts as seen, and how its saliency becomes a box."""

    min_score: float = 0.5  # two-prompt score: the object must beat "something else" ([V] Sec. III-C)
    level: float = 0.5  # share of the saliency's peak that belongs to the object (CoW uses 0.5 of the normalized map)


class Detector:
    """Turns views into boxes of a target."""

    def __init__(self, encoder: Encoder, config: DetectorConfig | None = None):
        self._encoder = encoder
        self._config = config or DetectorConfig()

    def score(self, view: View, target: Target) -> float:
        """[V] Eq. 2 for the best of the view's regions: a whole picture hides small things."""
        return float(self.softmax((view.vectors @ target.direction).max()))

    def softmax(self, dots):
        """[V] Eq. 2: the softmax over the two prompts, from dot products of vectors with the target's direction."""
        return 1 / (1 + np.exp(-self._encoder.logit_scale * np.asarray(dots, float)))

    def detect(self, view: View, target: Target, image_size: tuple[int, int]) -> Detection | None:
        """Box of ``target`` in the picture of ``image_size`` (width, height) px behind ``view``; None if not seen."""
        score = self.score(view, target)
        if score < self._config.min_score:
            return None
        left, top, right, bottom = view.window or (0, 0, *image_size)
        size = (right - left, bottom - top)
        region = salient_region(self._encoder.saliency(view, target.direction), size, self._config.level)
        if region is None:
            return None
        box, mask = region
        return Detection((left + box[0], top + box[1], left + box[2], top + box[3]), score, mask)


def salient_region(saliency: np.ndarray, image_size: tuple[int, int], level: float):
    """Box (x0, y0, x1, y1) px of the strongest component of ``saliency`` (h, w) above ``level`` of its peak.

    And which pixels of the box are the component's, ``(y1 - y0, x1 - x0)`` bool.

    The map is enlarged to ``image_size`` (width, height) first, so that the box is not cut to whole cells. The
    component with the largest saliency summed over it wins, rather than the largest area: [V] says largest, which on a
    map of 7 x 9 cells prefers a wide faint smear over the object. None when the map is zero.
    """
    peak = float(saliency.max(initial=0.0))
    if not np.isfinite(peak) or peak <= 0:
        return None
    smooth = cv2.resize(saliency.astype(np.float32), image_size, interpolation=cv2.INTER_LINEAR)
    mask = (smooth >= level * smooth.max()).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=4)
    mass = np.bincount(labels.reshape(-1), weights=smooth.reshape(-1), minlength=count)
    best = 1 + int(np.argmax(mass[1:]))
    x, y, width, height = (int(stats[best, i]) for i in range(4))
    return (float(x), float(y), float(x + width), float(y + height)), labels[y : y + height, x : x + width] == best
