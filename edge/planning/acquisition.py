"""Which frontier promises most: the acquisition functions of [U] Sec. IV over relevance mean and variance."""

from math import erf, exp, pi, sqrt

import numpy as np

BETA = 1.0  # of GP-UCB; [U] gives none


def expected_improvement(means, variances) -> np.ndarray:
    """[U] Eqs. 9-10 for frontiers with ``means (N,)`` and ``variances (N,)``: ``(N,)``, higher is better.

    The improvement is over the best of the means themselves.
    """
    means, deviations = np.asarray(means, float), np.sqrt(np.asarray(variances, float))
    gain = means - means.max(initial=-np.inf)
    safe = np.maximum(deviations, 1e-12)
    ratio = gain / safe
    below = np.array([0.5 * (1 + erf(z / sqrt(2))) for z in ratio])
    density = np.array([exp(-z * z / 2) / sqrt(2 * pi) for z in ratio])
    return np.where(deviations > 0, gain * below + deviations * density, np.maximum(gain, 0.0))


def upper_confidence_bound(means, variances, beta: float = BETA) -> np.ndarray:
    """[U] Eq. 11, GP-UCB: mean + sqrt(beta) * deviation, ``(N,)``."""
    return np.asarray(means, float) + sqrt(beta) * np.sqrt(np.asarray(variances, float))
