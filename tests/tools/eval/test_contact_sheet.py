import cv2
import numpy as np
import pytest

from tools.eval.contact_sheet import BAD, GOOD, LIMIT, Tile, contact_sheet, save


def plain(colour, shape=(30, 40)):
    return np.full((*shape, 3), colour, np.uint8)


def test_each_picture_is_in_its_place_and_whole():
    red, green, blue = ([200, 0, 0], [0, 200, 0], [0, 0, 200])
    tiles = [Tile(plain(colour), (("name", GOOD),)) for colour in (red, green, blue)]
    sheet = contact_sheet(tiles, 2, (80, 60))
    assert sheet[30, 40].tolist() == red and sheet[30, 130].tolist() == green
    deep = sheet.shape[0] // 2
    assert sheet[deep + 30, 40].tolist() == blue and sheet[deep + 30, 130].tolist() == [255] * 3


def test_proportions_are_kept():
    sheet = contact_sheet([Tile(plain([0, 0, 0], (10, 100)), (("", BAD),))], 1, (100, 60))
    dark = (sheet == 0).all(2)
    assert dark.any(0).sum() == 100 and dark.any(1).sum() == 10


def test_words_are_written_in_their_colour_and_cut_to_the_tile():
    tile = Tile(plain([255, 255, 255]), (("a name that is far too long for the tile it is below", BAD),))
    sheet = contact_sheet([tile, Tile(plain([255, 255, 255]), (("", BAD),))], 2, (80, 60)).astype(int)
    inked = np.abs(sheet - 255).sum(2) > 60
    assert inked[:, :90].any() and not inked[:, 92:].any()
    assert np.abs(sheet[inked] - BAD).sum(1).min() < 30


def test_a_file_is_never_larger_than_the_limit(tmp_path):
    noise = np.random.default_rng(0).integers(0, 256, (600, 800, 3), dtype=np.uint8)
    save(noise, tmp_path / "noise.jpg")
    size = (tmp_path / "noise.jpg").stat().st_size
    assert 0 < size <= LIMIT and cv2.imread(str(tmp_path / "noise.jpg")).shape == noise.shape
    with pytest.raises(ValueError, match="fewer or smaller"):
        save(np.tile(noise, (3, 3, 1)), tmp_path / "more.jpg")
