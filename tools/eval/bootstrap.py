"""Confidence intervals by resampling homes: episodes of one home share its rooms, its map and its luck."""

import numpy as np

RESAMPLES = 2000
LEVEL = 0.95


def interval(values, homes, seed: int = 0) -> tuple[float, float]:
    """Percentile interval of the mean of ``values (N,)``, NaN left out, over resampled ``homes (N,)``.

    (NaN, NaN) without a value. With a single home the episodes themselves are resampled, as there is nothing else.
    """
    values, homes = np.asarray(values, float), np.asarray(homes)
    known = ~np.isnan(values)
    values, homes = values[known], homes[known]
    if not len(values):
        return np.nan, np.nan
    _, group = np.unique(homes, return_inverse=True)
    if group.max() == 0:
        group = np.arange(len(values))
    sums, counts = np.bincount(group, values), np.bincount(group)
    times = resampled(len(sums), seed)
    return middle((times @ sums) / (times @ counts))


def resampled(count: int, seed: int = 0) -> np.ndarray:
    """How often each of ``count`` homes is in each resample: ``(RESAMPLES, count)``."""
    drawn = np.random.default_rng(seed).integers(count, size=(RESAMPLES, count))
    return np.stack([np.bincount(homes, minlength=count) for homes in drawn])


def middle(values) -> tuple[float, float]:
    """The ends of what ``LEVEL`` of the ``values`` lie between."""
    low, high = np.quantile(values, ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
    return float(low), float(high)
