"""With the training extra installed only."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("efficientnet_lite_pytorch")

from tools.assets.catalog import Entry  # noqa: E402
from tools.train.features import Features  # noqa: E402
from tools.train.head import TrainConfig, Vocabulary, contrastive_loss, pool_windows, sample, train  # noqa: E402
from tools.train.image_tower import CHANNELS, Head  # noqa: E402

DIM = 16


def encode(texts):
    """A stand-in text tower: each word has its own direction, a text is the mean of its words'."""
    rows = []
    for text in texts:
        words = [np.random.default_rng(sum(word.encode())).normal(size=DIM) for word in text.lower().split()]
        rows.append(np.mean(words, 0))
    rows = np.array(rows)
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


def entry(name):
    rotation = np.eye(3)
    return Entry("Toy", name, name, (), "Office", (1, 1, 1), None, None, rotation, False, False, "me", "CC0", "x.obj")


@pytest.fixture
def toy():
    """Three kinds of things, each with its own channel, alone in the left or the right half of 60 scenes."""
    rng = np.random.default_rng(0)
    model, left = rng.integers(3, size=60), rng.integers(2, size=60)
    maps = rng.integers(0, 20, (60, 7, 9, CHANNELS)).astype(np.uint8)
    presence = np.zeros((60, 7, 9), np.float16)
    for scene in range(60):
        columns = slice(0, 4) if left[scene] else slice(5, 9)
        maps[scene, :, columns, model[scene]] = 200
        presence[scene, :, columns] = 1
    return [entry(name) for name in ("lamp", "sofa", "fridge")], Features(
        maps, np.arange(60), model, presence, np.ones(60, np.float32)
    )


def test_training_learns_what_is_where(toy):
    entries, features = toy
    torch.manual_seed(0)
    classifier = torch.nn.Linear(CHANNELS, 5)
    head = Head(classifier, torch.nn.functional.normalize(torch.randn(5, DIM), dim=1), 0.3).requires_grad_(False)
    vocabulary = Vocabulary(entries, encode)
    config = TrainConfig(windows=3, steps=60, batch=64, rate=1e-2)
    train(head, sample(features, vocabulary, config), vocabulary, config)
    whole = pool_windows(features.maps, np.tile([0, 7, 0, 9], (60, 1)))
    scores = head(whole).detach() @ vocabulary.directions[0].T
    named = np.array(vocabulary.names)[scores.argmax(1)]
    assert (named == np.array(["lamp", "sofa", "fridge"])[features.model]).mean() > 0.85  # chance: a third


def test_truth_neither_denies_synonyms_nor_what_is_hardly_visible():
    vocabulary = Vocabulary([entry(name) for name in ("lamp", "old lamp", "sofa", "fridge")], encode)
    vocabulary.cosines = np.eye(4)
    fridge, lamp, old, sofa = range(4)
    vocabulary.cosines[lamp, old] = vocabulary.cosines[old, lamp] = 0.9
    named, doubtful = np.zeros((1, 4), bool), np.zeros((1, 4), bool)
    named[0, 0] = doubtful[0, 2] = True
    positive, negative = vocabulary.truth(named, doubtful, 0.65)
    assert positive[0].tolist() == [False, True, False, False]
    assert negative[0].tolist() == [True, False, False, False]


def test_the_loss_falls_when_positives_rise_and_negatives_sink():
    positive = torch.tensor([[True, False, False], [False, True, False]])
    negative = torch.tensor([[False, True, True], [True, False, False]])
    good = torch.where(positive, 3.0, -3.0)
    assert contrastive_loss(good, positive, negative) < contrastive_loss(torch.zeros(2, 3), positive, negative)
    # What is neither named nor denied does not matter.
    other = good.clone()
    other[1, 2] = 50.0
    torch.testing.assert_close(contrastive_loss(other, positive, negative), contrastive_loss(good, positive, negative))
