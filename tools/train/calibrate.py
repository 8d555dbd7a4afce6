"""From cosines to probabilities, fitted on the validation models: the manifest's relevance."""

import numpy as np

from tools.assets.catalog import Entry
from tools.train.features import SHOWN, Features
from tools.train.words import names


def logistic(x: np.ndarray, y: np.ndarray, steps: int = 50) -> tuple[float, float]:
    """Slope and offset of P(y) = sigmoid(slope x + offset) by Newton's method, both classes given equal weight.

    Raises:
        ValueError: only one class is there.
    """
    y = np.asarray(y, bool)
    if y.all() or not y.any():
        raise ValueError("A calibration needs both cases: pictures with the object and pictures without it.")
    weight = np.where(y, 0.5 / y.sum(), 0.5 / (~y).sum())
    design = np.stack([x, np.ones(len(x))], 1)
    theta = np.zeros(2)
    for _ in range(steps):
        p = 1 / (1 + np.exp(-design @ theta))
        gradient = design.T @ (weight * (y - p))
        hessian = (design * (weight * p * (1 - p))[:, None]).T @ design + 1e-9 * np.eye(2)
        theta += np.linalg.solve(hessian, gradient)
    return float(theta[0]), float(theta[1])


def presence(features: Features, entries: list[Entry], nouns: list[str], regions) -> np.ndarray:
    """(N, R, V) float32: 1 where a region truly shows something of that name, 0 where not, NaN where one cannot say."""
    width = features.presence.shape[2]
    truth = np.zeros((len(features.middle), len(regions), len(nouns)), np.float32)
    place = {name: i for i, name in enumerate(nouns)}
    for k, (scene, model) in enumerate(zip(features.scene, features.model)):
        columns = [place[name] for name in names(entries[model]) if name in place]
        for r, (a, b) in enumerate(regions):
            share = features.presence[k, :, round(a * width) : round(b * width)].mean(dtype=np.float32)
            if share > 2 * SHOWN[0] and features.visible[k] > SHOWN[1]:
                truth[scene, r, columns] = 1
            elif share > 0:
                truth[scene, r, columns] = np.where(truth[scene, r, columns] == 1, 1, np.nan)
    return truth
