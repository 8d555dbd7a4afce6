import numpy as np
import pytest

from tools.assets.catalog import Entry


def _entry(name, size=(0.6, 0.6, 0.9), tags=()):
    rotation = np.eye(3)
    return Entry("Toy", name, name, tags, "Living room", size, None, None, rotation, False, False, "me", "CC0", "x.obj")


def _encode(texts):
    """A stand-in text tower: each word has its own direction, a text is the mean of its words'."""
    rows = []
    for text in texts:
        words = [np.random.default_rng(sum(word.encode())).normal(size=16) for word in text.lower().split()]
        rows.append(np.mean(words, 0))
    rows = np.array(rows)
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


@pytest.fixture
def entry():
    """Makes catalog entries."""
    return _entry


@pytest.fixture
def encode():
    """Texts to unit vectors (N, 16)."""
    return _encode
