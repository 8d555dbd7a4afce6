import numpy as np
import pytest

from tools.assets.catalog import Entry
from tools.train.scenes import SceneMaker
from tools.train.sprites import Sprite


def entry(name, size=(0.6, 0.6, 0.9), tags=()):
    rotation = np.eye(3)
    return Entry("Toy", name, name, tags, "Living room", size, None, None, rotation, False, False, "me", "CC0", "x.obj")


@pytest.fixture
def maker():
    """Two models: a red and a green board, 100 px a metre."""
    sprites = []
    for colour in ((255, 0, 0), (0, 255, 0)):
        rgba = np.full((90, 60, 4), 255, np.uint8)
        rgba[..., :3] = colour
        sprites.append([Sprite(rgba, 100.0)])
    return SceneMaker([entry("red board"), entry("green board")], sprites, seed=3)


def test_a_close_up_shows_its_model_where_presence_says(maker):
    scene = maker.close_up(0)
    assert scene.models.tolist() == [0] and scene.rgb.shape == (240, 320, 3)
    assert scene.visible[0] == pytest.approx(1, abs=0.05)
    cells = scene.rgb[:238].reshape(7, 34, 320, 3)[:, :, :315].reshape(7, 34, 9, 35, 3).mean((1, 3))
    redness = cells[..., 0] - cells[..., 1:].mean(-1)
    assert redness[scene.presence[0] > 0.95].min() > redness[scene.presence[0] == 0].max()


def test_views_keep_their_own_truth(maker):
    for _ in range(20):
        scene = maker.view(4)
        assert len(scene.models) == len(scene.presence) == len(scene.visible) == 4
        assert (scene.presence >= 0).all() and scene.presence.sum(0).max() <= 1 + 1e-5
        assert scene.visible.max() <= 1.1


def test_an_empty_room_is_empty(maker):
    scene = maker.empty()
    assert len(scene.models) == 0 and scene.presence.shape == (0, 7, 9)


def test_the_same_seed_draws_the_same_scenes(maker):
    again = SceneMaker(maker._entries, maker._sprites, seed=3)
    np.testing.assert_array_equal(maker.view(3).rgb, again.view(3).rgb)


def test_an_enlarged_part_keeps_its_truth(maker, monkeypatch):
    monkeypatch.setattr("tools.train.scenes.ENLARGED", 1.0)
    seen = 0
    for _ in range(40):
        scene = maker.view(1)
        if scene.presence[0].max() > 0.98 and scene.visible[0] > 0.3:
            row, col = np.unravel_index(scene.presence[0].argmax(), (7, 9))
            patch = scene.rgb[int((row + 0.5) * 240 / 7), int((col + 0.5) * 320 / 9)].astype(int)
            assert patch[scene.models[0]] > patch[1 - scene.models[0]] + 60
            seen += 1
    assert seen > 3
