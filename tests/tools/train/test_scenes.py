import cv2
import numpy as np
import pytest

from tools.train.scenes import CELLS, SceneMaker, _around, _tint
from tools.train.sprites import Sprite


@pytest.fixture
def maker(entry, monkeypatch):
    """Two models: a red and a green board, 100 px a metre, that keep their colours."""
    monkeypatch.setattr("tools.train.scenes.RECOLOURED", 0.0)
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
    cells = cv2.resize(scene.rgb.astype(np.float32), CELLS[::-1], interpolation=cv2.INTER_AREA)
    redness = cells[..., 0] - cells[..., 1:].mean(-1)
    assert redness[scene.presence[0] > 0.95].min() > redness[scene.presence[0] == 0].max()


def test_another_colour_is_as_bright(monkeypatch):
    rng = np.random.default_rng(1)
    monkeypatch.setattr("tools.train.scenes.RECOLOURED", 1.0)
    rows = np.stack([np.array([200.0, 80.0, 60.0]) @ _tint(rng) for _ in range(200)])
    brightness, hue = rows.mean(1), np.arctan2(rows[:, 1] - rows[:, 2], 2 * rows[:, 0] - rows[:, 1] - rows[:, 2])
    assert 75 < brightness.min() < brightness.max() < 150  # 113 in other light
    assert np.ptp(hue) > 1.5
    greys = np.array([99.0, 99.0, 99.0]) @ _tint(rng)
    assert np.ptp(greys) < 25  # what has no colour gets none


def test_a_look_is_around_a_thing():
    rng, owner = np.random.default_rng(0), np.full((240, 320), -1)
    owner[100:140, 50:90] = 0
    for _ in range(40):
        part = owner[_around(rng, owner)]
        assert part.shape[1] == pytest.approx(part.shape[0] * 4 / 3, abs=2)
        assert (part == 0).sum() > 0.7 * 1600 and (part == 0).mean() > 0.12


def test_views_keep_their_own_truth(maker):
    for _ in range(20):
        scene = maker.view(4)
        assert len(scene.models) == len(scene.presence) == len(scene.visible) == 4
        assert (scene.presence >= 0).all() and scene.presence.sum(0).max() <= 1 + 1e-5
        assert scene.visible.max() <= 1.1


def test_an_empty_room_is_empty(maker):
    scene = maker.empty()
    assert len(scene.models) == 0 and scene.presence.shape == (0, *CELLS)


def test_the_same_seed_draws_the_same_scenes(maker):
    again = SceneMaker(maker._entries, maker._sprites, seed=3)
    np.testing.assert_array_equal(maker.view(3).rgb, again.view(3).rgb)


def test_an_enlarged_part_keeps_its_truth(maker, monkeypatch):
    monkeypatch.setattr("tools.train.scenes.ENLARGED", 1.0)
    seen = 0
    for _ in range(40):
        scene = maker.view(1)
        if scene.presence[0].max() > 0.98 and scene.visible[0] > 0.3:
            row, col = np.unravel_index(scene.presence[0].argmax(), CELLS)
            patch = scene.rgb[int((row + 0.5) * 240 / CELLS[0]), int((col + 0.5) * 320 / CELLS[1])].astype(int)
            assert patch[scene.models[0]] > patch[1 - scene.models[0]] + 60
            seen += 1
    assert seen > 3
