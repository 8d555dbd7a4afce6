"""Evidence for and against an obstacle in a cell, as clamped log-odds in small integers."""

from dataclasses import dataclass

import numpy as np

STEP = 0.05  # log-odds of one count of an int8 layer; +-127 counts reach +-6.35, far beyond the clamps


@dataclass(frozen=True)
class LogOddsConfig:
    """Inverse sensor model of one layer: OctoMap's values (Hornung et al. 2013), clamped so that maps can change."""

    hit: float = 0.85  # log-odds added to a cell that returned a beam, p = 0.70
    miss: float = 0.40  # log-odds taken from a cell that a beam crossed, p = 0.40
    lowest: float = -2.0  # clamp, p = 0.12: an object put there shows after three hits
    highest: float = 3.5  # clamp, p = 0.97: a removed one is gone after nine misses

    def __post_init__(self):
        if not (self.hit > 0 and self.miss > 0 and self.lowest < 0 < self.highest):
            raise ValueError("Log-odds need hit > 0, miss > 0 and lowest < 0 < highest.")
        if max(self.highest + self.hit, self.miss - self.lowest) > 127 * STEP:
            raise ValueError(f"Log-odds beyond +-{127 * STEP} do not fit a map cell; choose smaller clamps.")


def count(log_odds: float) -> int:
    """Log-odds in counts of an int8 layer, rounded."""
    return round(log_odds / STEP)


def update(layer: np.ndarray, hit: np.ndarray, miss: np.ndarray, config: LogOddsConfig) -> None:
    """Adds one measurement to ``layer`` in place: l <- clip(l + hit or - miss) (Thrun et al. 2005, table 9.1).

    ``layer`` is int8 ``(H, W)`` in counts of ``STEP``, ``hit`` and ``miss`` uint8 ``(H, W)`` of 0 and 1. A cell that
    was hit is not missed as well: a beam that grazes a wall must not wipe out what its neighbour found there.
    """
    change = hit.view(np.int8) * np.int8(count(config.hit))
    change -= (miss & ~hit & 1).view(np.int8) * np.int8(count(config.miss))
    layer += change
    np.clip(layer, count(config.lowest), count(config.highest), out=layer)
