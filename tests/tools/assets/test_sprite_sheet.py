import numpy as np
import pytest

from firmware_sim.sprites import SpriteSheet
from tools.assets.catalog import open_library
from tools.assets.obj_model import load_mesh
from tools.assets.rasterizer import render
from tools.assets.sprite_sheet import draw_sheet, pitches


def test_pitches_follow_how_high_a_thing_is():
    floor = pitches((1.0, 1.0, 0.8), None)
    hung = pitches((0.6, 0.4, 0.7), 1.45)
    small = pitches((0.2, 0.2, 0.2), None)
    assert all(pitch > 0 for pitch in floor)
    assert all(pitch < 0 for pitch in hung)
    assert len(small) == 3 and small[-1] - small[0] > 25  # on the floor and on a table
    assert len(pitches((0.9, 0.9, 1.75), None)) == 1


def test_sheets_read_back_as_the_pictures_they_were_made_from(make_library, tmp_path):
    library = open_library(make_library())
    mesh = load_mesh(library, library.entries[0])
    made = draw_sheet(mesh, None)
    (tmp_path / "a.webp").write_bytes(made.colour)
    (tmp_path / "b.webp").write_bytes(made.relief)
    sheet = SpriteSheet(tmp_path / "a.webp", tmp_path / "b.webp", made.layout)
    sprite = sheet.nearest(-1.1, 0.3)
    assert abs(sprite.yaw + 1.1) <= np.pi / 16 + 1e-9
    view = render(mesh, sprite.yaw, sprite.pitch, made.cell, made.scale)
    rgba = sprite.levels[0]
    assert np.abs(rgba[..., 3].astype(int) - view.rgba[..., 3]).max() <= 1
    inside = view.rgba[..., 3] == 255
    assert np.abs(rgba[inside][:, :3].astype(int) - view.rgba[inside][:, :3]).mean() < 12  # lossy
    error = np.abs(sprite.relief - view.depth)[inside]
    assert np.median(error) < 0.005
    assert np.quantile(error, 0.95) < 0.03
    assert sprite.span[0] == pytest.approx(np.nanmin(view.depth), abs=0.02)
