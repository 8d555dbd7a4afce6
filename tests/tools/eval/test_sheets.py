import cv2
import numpy as np
import pytest

from tools.eval import sheets
from tools.eval.naming import Answer


@pytest.fixture
def pictures(tmp_path):
    """Two models from three yaws, the one red and the other blue."""
    for name, bgr in (("bed", (0, 0, 200)), ("cup", (200, 0, 0))):
        for i in range(3):
            cv2.imwrite(str(tmp_path / f"{name}.{i}.png"), np.full((24, 32, 3), bgr, np.uint8))
    return tmp_path


def answers():
    wrong = [Answer(f"cup.{i}.png", "cup", 3, ("bed", "rug", "vase", "cup", "sofa")) for i in range(3)]
    right = [Answer(f"bed.{i}.png", "bed", 0, ("bed", "rug", "vase", "cup", "sofa")) for i in range(3)]
    return right + wrong


def colours(path):
    """Shares of red and of blue pixels."""
    bgr = cv2.imread(str(path)).astype(int)
    return [(np.abs(bgr - colour).sum(2) < 60).mean() for colour in ((0, 0, 200), (200, 0, 0))]


def test_each_held_out_model_is_shown_once(pictures, tmp_path):
    sheets.held_out_sheet(answers(), pictures, tmp_path / "all.jpg")
    red, blue = colours(tmp_path / "all.jpg")
    assert red > 0 and red == pytest.approx(blue, rel=0.1)


def test_only_mistakes_are_among_the_confusions(pictures, tmp_path):
    sheets.confusions_sheet(answers(), pictures, tmp_path / "wrong.jpg")
    red, blue = colours(tmp_path / "wrong.jpg")
    assert red == 0 and blue > 0.1


def test_photographs_without_credit_are_not_reprinted(monkeypatch, tmp_path):
    asked = []

    def load(photograph):
        asked.append(photograph.file)
        return np.zeros((20, 30, 3), np.uint8)

    monkeypatch.setattr(sheets, "load", load)
    best = ("a", "b", "c", "d", "e")
    files = [photograph.file for photograph in sheets.PHOTOGRAPHS]
    sheets.photographs_sheet([Answer(file, "a", 0, best) for file in files], tmp_path / "photos.jpg")
    assert set(files) - set(asked) == {"data/motorcycle_left.png"}
    assert (tmp_path / "photos.jpg").exists()
