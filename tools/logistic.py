"""Logistic regression: from evidence to probabilities."""

import numpy as np

STEPS = 50  # of Newton's method; a few are enough where the classes overlap


def logistic(x: np.ndarray, y: np.ndarray, balanced: bool = False, ridge: float = 0.0) -> np.ndarray:
    """Weights and offset ``(F + 1,)`` of P(y) = sigmoid(x . weights + offset), for ``x (N,)`` or ``(N, F)``.

    ``balanced`` gives both classes equal weight; ``ridge`` is the penalty on half the squared weights, not the offset.

    Raises:
        ValueError: only one class is there.
    """
    y = np.asarray(y, bool)
    if y.all() or not y.any():
        raise ValueError("A calibration needs both cases, what is so and what is not, and only one is there.")
    weight = np.where(y, 0.5 / y.sum(), 0.5 / (~y).sum()) if balanced else np.ones(len(y))
    design = np.column_stack([x, np.ones(len(y))])
    penalty = np.append(np.full(design.shape[1] - 1, ridge), 0.0)
    theta = np.zeros(design.shape[1])
    for _ in range(STEPS):
        p = 1 / (1 + np.exp(-design @ theta))
        gradient = design.T @ (weight * (y - p)) - penalty * theta
        hessian = (design * (weight * p * (1 - p))[:, None]).T @ design + np.diag(penalty + 1e-9)
        theta += np.linalg.solve(hessian, gradient)
    return theta
