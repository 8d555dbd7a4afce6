"""The map of VLFM (Yokoyama et al. 2024), the baseline's: in each cell a value, weighted by how well it was seen."""

import numpy as np

from edge.mapping.relevance import RelevanceConfig, RelevanceMap


class ValueMap(RelevanceMap):
    """``mean`` is the value; ``variance`` is one minus its confidence, which no planner reads."""

    def __init__(self):
        super().__init__(RelevanceConfig(mean=0.0, variance=1.0))

    def fuse(self, cells, relevance, confidence) -> None:
        """New value (c v + c' v') / (c + c') and new confidence (c^2 + c'^2) / (c + c'), from the views' so far."""
        old = 1 - self.variance[cells]
        confidence = np.maximum(confidence, 1e-6).astype(np.float32)  # at the very edge of the picture it is 0
        total = old + confidence
        self.mean[cells] = (old * self.mean[cells] + confidence * np.float32(relevance.mean())) / total
        self.variance[cells] = 1 - (old**2 + confidence**2) / total

    def around(self, place, radius: float) -> tuple[float, float]:
        """Medians over the cells of the disc that were seen, as VLFM takes them: others have no value, not 0."""
        rows, cols = self.disc(place, radius)
        seen = self.variance[rows, cols] < self.config.variance
        if not seen.any():
            return self.config.mean, self.config.variance
        return float(np.median(self.mean[rows, cols][seen])), float(np.median(self.variance[rows, cols][seen]))
