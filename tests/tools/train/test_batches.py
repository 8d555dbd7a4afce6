"""With the training extra installed only."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from tools.train.batches import Batches  # noqa: E402
from tools.train.features import Features  # noqa: E402

REGIONS = ((0.0, 1.0), (0.0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1.0))


@pytest.fixture
def features():
    """Ten scenes, each with model 0 in the left third and model 1, hardly visible, in the right third."""
    rng = np.random.default_rng(0)
    presence = np.zeros((20, 14, 18), np.float16)
    presence[0::2, 5:9, 0:6], presence[1::2, 5:9, 12:18] = 1, 1
    return Features(
        middle=rng.normal(size=(10, 112, 14, 18)).astype(np.float16),
        logits=np.arange(4.0)[None, :, None].repeat(10, 0).repeat(1000, 2).astype(np.float16),
        scene=np.repeat(np.arange(10), 2),
        model=np.tile([0, 1], 10),
        presence=presence,
        visible=np.tile(np.array([1.0, 0.1], np.float32), 10),
    )


def batches(features, count=12):
    stream = iter(Batches(features, REGIONS, models=3, size=4, extra=2, seed=0))
    return [next(stream) for _ in range(count)]


def test_windows_name_what_they_show_and_doubt_what_is_hidden(features):
    for batch in batches(features):
        mirrored = bool((batch.logits[0, 1] == 3).all())
        near, far = (3, 1) if mirrored else (1, 3)
        assert batch.named[:, 0, 0].all() and batch.named[:, near, 0].all()
        assert not batch.named[:, 2].any() and not batch.named[:, :, 1].any()
        assert batch.doubtful[:, 0, 1].all() and batch.doubtful[:, far, 1].all()
        assert not batch.doubtful[:, near, 1].any()


def test_some_batches_are_mirrored_with_all_that_belongs_to_them(features):
    mirrored = [bool((batch.logits[0, 1] == 3).all()) for batch in batches(features)]
    assert any(mirrored) and not all(mirrored)
    for batch, flipped in zip(batches(features), mirrored):
        assert bool(batch.presence[0, 6, 17] > 0) == bool(flipped)  # of model 0
        assert any(np.array_equal(batch.middle[0].flip(2) if flipped else batch.middle[0], m) for m in features.middle)


def test_only_what_is_visible_is_pointed_at(features):
    batch = batches(features, 1)[0]
    assert batch.model.tolist() == [0] * 4 and batch.scene.tolist() == [0, 1, 2, 3]
    assert len(batch.presence) == len(batch.shown) == 8


def test_extra_windows_span_at_least_three_cells(features):
    for batch in batches(features):
        extra = batch.windows[:, 4:]
        assert (extra.amax(3).sum(2) >= 3).all() and (extra.amax(2).sum(2) >= 3).all()
