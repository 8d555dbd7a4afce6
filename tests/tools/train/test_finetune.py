"""With the training extra installed only."""

import copy

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("efficientnet_lite_pytorch")

from efficientnet_lite_pytorch import EfficientNet  # noqa: E402

from tools.train.batches import Batches  # noqa: E402
from tools.train.features import Features  # noqa: E402
from tools.train.finetune import TrainConfig, pool_windows, train  # noqa: E402
from tools.train.image_tower import DEEP, Head, ImageTower, Neck, Trunk, grad_cam, pool  # noqa: E402
from tools.train.vocabulary import Vocabulary  # noqa: E402

REGIONS = ((0.0, 1.0), (0.0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1.0))
CONFIG = TrainConfig(steps=24, batch=12, warm_up=4, rate=3e-3, average=0.8, every=8)


@pytest.fixture
def tower():
    torch.manual_seed(0)
    trunk = Trunk(EfficientNet.from_name("efficientnet-lite0"))
    head = Head(torch.nn.Linear(DEEP, 5), torch.nn.functional.normalize(torch.randn(5, 16), dim=1), 0.3)
    return ImageTower(trunk, Neck(), head, REGIONS).requires_grad_(False)


@pytest.fixture
def toy(entry, encode):
    """Three kinds of things, each with channels of its own, alone in the left or the right half of 36 scenes."""
    rng = np.random.default_rng(0)
    model, left = rng.integers(3, size=36), rng.integers(2, size=36)
    middle = rng.normal(0, 0.3, (36, 112, 14, 18))
    presence = np.zeros((36, 14, 18), np.float16)
    for scene in range(36):
        columns = slice(0, 8) if left[scene] else slice(10, 18)
        middle[scene, 30 * model[scene] : 30 * model[scene] + 30, 4:12, columns] += 4
        presence[scene, 4:12, columns] = 1
    entries = [entry(name) for name in ("lamp", "sofa", "fridge")]
    logits = rng.normal(size=(36, 4, 5)).astype(np.float16)
    features = Features(middle.astype(np.float16), logits, np.arange(36), model, presence, np.ones(36, np.float32))
    return Vocabulary(entries, encode), features


def batches(features):
    return Batches(features, REGIONS, 3, CONFIG.batch, CONFIG.windows, CONFIG.seed)


def test_training_learns_what_is_where(tower, toy, tmp_path):
    vocabulary, features = toy
    middle = torch.from_numpy(features.middle).float()
    train(tower, batches(features), vocabulary, CONFIG, tmp_path / "checkpoint")
    with torch.no_grad():
        deep, detail = tower.maps(middle)
        scores = tower.head(pool(deep, detail, REGIONS)[:, 0]) @ vocabulary.directions[0].T
        place = [vocabulary.names.index(name) for name in ("lamp", "sofa", "fridge")]
        asked = vocabulary.directions[0][place][features.model]
        peaks = grad_cam(tower.head, deep, detail, asked).flatten(1).argmax(1)
    right = np.array(place)[features.model]
    assert (scores.argmax(1).numpy() == right).mean() > 0.8  # chance: a third
    assert features.presence.reshape(36, -1)[np.arange(36), peaks].mean() > 0.8  # chance: a quarter
    assert not list(tmp_path.iterdir())


def test_an_interrupted_training_goes_on(tower, toy, tmp_path, monkeypatch):
    vocabulary, features = toy
    checkpoint = tmp_path / "checkpoint"
    saves = []

    def stop_after_two(content, path, save=torch.save):
        save(content, path)
        saves.append(content["step"])
        if len(saves) == 2:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(torch, "save", stop_after_two)
        with pytest.raises(KeyboardInterrupt):
            train(copy.deepcopy(tower), batches(features), vocabulary, CONFIG, checkpoint)
    assert saves == [8, 16]
    steps = []
    monkeypatch.setattr(torch, "save", lambda content, path: steps.append(content["step"]))
    train(tower, batches(features), vocabulary, CONFIG, checkpoint)
    assert steps == [24] and not checkpoint.exists()


def test_windows_pool_as_regions_do(tower):
    deep, detail = torch.rand(2, 8, 7, 9), torch.rand(2, 4, 14, 18)
    windows = torch.zeros(2, 4, 7, 9)
    for k, (first, last) in enumerate(((0, 9), (0, 3), (3, 6), (6, 9))):
        windows[:, k, :, first:last] = 1
    torch.testing.assert_close(pool_windows(deep, detail, windows), pool(deep, detail, REGIONS))
