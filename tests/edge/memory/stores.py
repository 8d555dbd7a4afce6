"""Stores of random views."""

import numpy as np

from edge.memory.gate import GateConfig
from edge.memory.store import Vlpg, VlpgConfig

DIM = 32
COVARIANCE = np.array([[0.01, 0.002, 0.0], [0.002, 0.02, 0.001], [0.0, 0.001, 0.005]])
DENSE = VlpgConfig(gate=GateConfig(policy="dense", disagreement=-1.0))


def opened(path=":memory:", config=DENSE, encoder="tower", digest="ab" * 32, dim=DIM):
    return Vlpg.open(path, encoder, digest, dim, config)


def unit(rng, n, dim=DIM):
    rows = rng.normal(size=(n, dim)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def walk(store, rng, steps, regions=4):
    """Adds ``steps`` random views along a line; returns their vectors."""
    views = [unit(rng, regions, store.dim) for _ in range(steps)]
    for n, vectors in enumerate(views):
        assert store.add(n / 10, (n, 0.5, 0.1 * n), COVARIANCE, vectors, np.linspace(-0.4, 0.4, regions)) == n
    return views
