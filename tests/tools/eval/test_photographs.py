import pytest

from tools.eval import photographs
from tools.eval.photographs import DISTRACTORS, PHOTOGRAPHS, load, vocabulary


def test_every_right_name_can_be_said_and_no_wrong_one_is_right():
    names = vocabulary()
    assert len(names) == len(set(names)) > 200
    for photograph in PHOTOGRAPHS:
        assert set(photograph.truths) <= set(names)
        assert not set(photograph.truths) & set(DISTRACTORS)


def test_those_of_scikit_learn_are_there():
    pytest.importorskip("sklearn")
    found = [load(photograph) for photograph in PHOTOGRAPHS if photograph.package == "sklearn"]
    assert len(found) == 2 and all(rgb.ndim == 3 and rgb.mean() > 10 for rgb in found)
    flower = found[1]
    assert flower[200:250, 300:350].mean((0, 1)).argmax() == 0  # RGB: the flower in its middle is orange


def test_a_package_that_is_not_installed_gives_none(monkeypatch):
    monkeypatch.setattr(photographs.importlib.util, "find_spec", lambda name: None)
    assert load(PHOTOGRAPHS[0]) is None


def test_what_is_reprinted_says_whose_it_is():
    assert all(photograph.credit for photograph in PHOTOGRAPHS if "motorcycle" not in photograph.file)
