import json
import shutil

import cv2
import numpy as np
import pytest

from firmware_sim.furniture import PACK, Furniture, FurnitureError


@pytest.fixture(scope="module")
def furniture():
    return Furniture.load()


def test_the_pack_is_at_most_20_megabytes():
    assert sum(path.stat().st_size for path in PACK.iterdir()) <= 20e6


def test_there_is_enough_to_furnish_homes(furniture):
    assert len(furniture) >= 150
    assert len({model.name for model in furniture.values()}) >= 120
    for room in ("Kitchen", "Bathroom", "Bedroom", "Living room", "Office"):
        assert sum(model.category == room for model in furniture.values()) >= 10
    assert {"teddy-bear", "refrigerator", "basketball"} <= set(furniture)


def test_every_model_is_public_domain_and_credited(furniture):
    credits = (PACK / "CREDITS.md").read_text(encoding="utf-8")
    for model in furniture.values():
        assert model.licence == "CC0-1.0"
        assert f"| {model.id} | {model.name} | {model.creator} |" in credits


def test_no_file_lacks_a_model(furniture):
    expected = {f"{model}.{kind}" for model in furniture for kind in ("webp", "relief.webp")}
    assert {path.name for path in PACK.iterdir()} == expected | {"catalog.json", "CREDITS.md"}


def test_shapes_lie_within_the_model(furniture):
    for model in furniture.values():
        width, depth, height = model.size
        box = np.array([width, depth]) / 2 + 0.012
        hull = model.footprint
        assert (np.abs(hull) <= box).all(), model.id
        edge = np.roll(hull, -1, 0) - hull
        turn = edge[:, 0] * np.roll(edge, -1, 0)[:, 1] - edge[:, 1] * np.roll(edge, -1, 0)[:, 0]
        assert (turn > -1e-6).all(), f"{model.id}: not convex and counter-clockwise"
        assert len(model.slices) <= 48
        assert (np.abs(model.slices) <= box).all(), model.id
        if height < 0.25:
            assert len(model.slices) == 0
        assert model.top is None or 0 < model.top <= height + 0.01


def test_slices_lie_within_the_footprint(furniture):
    for model in furniture.values():
        hull = model.footprint.astype(np.float32).reshape(-1, 1, 2)
        for point in model.slices.reshape(-1, 2):
            assert cv2.pointPolygonTest(hull, point.astype(np.float32).tolist(), True) > -0.03, model.id


def test_every_sheet_decodes_and_shows_something(furniture):
    for model in furniture.values():
        sheet = model.sprites
        colour, relief = sheet.decode()
        assert colour.shape[2] == 4 and relief.dtype == np.uint8
        cells = colour[..., 3].reshape(len(sheet.pitches), sheet.height, sheet.yaws, sheet.width)
        assert (cells.max((1, 3)) > 160).all(), model.id  # glass is not opaque
        assert not cells[:, 0].any() and not cells[:, :, :, 0].any(), f"{model.id} is cut off"
        drawn = colour[::4, ::4][colour[::4, ::4, 3] > 160]
        assert drawn[:, :3].max() > 25, f"{model.id} is black"


def test_the_widest_picture_is_as_wide_as_the_model(furniture):
    for model in (furniture["teddy-bear"], furniture["refrigerator"], furniture["oak-table"]):
        sprite = model.sprites.nearest(-np.pi / 2, 0.0)
        columns = np.flatnonzero((sprite.levels[0][..., 3] > 127).any(0))
        assert sprite.yaw == pytest.approx(-np.pi / 2)
        assert np.ptp(columns) / sprite.scale == pytest.approx(model.size[0], abs=2.5 / sprite.scale)


def test_a_missing_pack_tells_how_to_make_it(tmp_path):
    with pytest.raises(FurnitureError, match="python -m tools.assets.furniture"):
        Furniture.load(tmp_path)


def test_a_damaged_pack_is_named(tmp_path, furniture):
    (tmp_path / "catalog.json").write_text('{"models": [{"id": "chair"}]}')
    with pytest.raises(FurnitureError, match="catalog.json is damaged"):
        Furniture.load(tmp_path)
    entry = next(m for m in json.loads((PACK / "catalog.json").read_text())["models"] if m["id"] == "teddy-bear")
    (tmp_path / "catalog.json").write_text(json.dumps({"models": [entry]}))
    shutil.copy(PACK / "teddy-bear.webp", tmp_path)
    (tmp_path / "teddy-bear.relief.webp").write_bytes(b"RIFF")
    with pytest.raises(ValueError, match="teddy-bear.relief.webp is missing or damaged"):
        Furniture.load(tmp_path)["teddy-bear"].sprites.nearest(0.0, 0.0)
