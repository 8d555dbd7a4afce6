import json

import pytest

from tools.eval import encoder
from tools.train.evaluate import HOMES

NAMING = {
    "top1": 0.27, "top5": 0.58, "seen_top1": 0.44, "seen_top5": 0.76, "unseen_top1": 0.16, "unseen_top5": 0.45,
    "names": 142, "pictures": 510, "confusions": [("rock", "bread", 9)], "said_too_often": [], "never_in_top5": [],
}  # fmt: skip
FOUND = {"queries": 41, "first": 0.25, "within10": 0.6, "sightings": 234, "pointing": 0.4, "iou": 0.2}
PHOTOS = {"names": 260, "pictures": 1, "answers": [{"truth": "cat", "rank": 4, "best": ["lion", "dog", "bed"]}]}


@pytest.fixture
def measured(monkeypatch):
    """Stands in for the measurements; what it returns says what was asked of the homes."""
    asked = []

    def homes(model, seeds):
        asked.append((model.name, seeds))
        return FOUND

    monkeypatch.setattr(encoder, "evaluate_homes", homes)
    monkeypatch.setattr(encoder, "evaluate_naming", lambda *_: NAMING)
    monkeypatch.setattr(encoder, "evaluate_photographs", lambda *_: PHOTOS)
    return asked


def test_prints_what_was_measured(measured, capsys):
    encoder.main(["--homes", "2"])
    assert measured == [("lite0-minilm", range(HOMES.start, HOMES.start + 2))]
    printed = capsys.readouterr().out
    figures = ("510 pictures", "142 names", "27.0%", "58.0%", "16.0%", "rock with bread (9)")
    for figure in (*figures, "41 names", "25.0%", "60.0%", "234 things", "40.0%", "20.0%", "cat", "name   5: lion"):
        assert figure in printed


def test_the_file_has_all_of_it(measured, tmp_path):
    encoder.main(["--homes", "1", "--json", str(tmp_path / "a.json"), "--sheets", str(tmp_path / "new" / "folder")])
    written = json.loads((tmp_path / "a.json").read_text())
    assert written["model"] == "lite0-minilm" and len(written["digest"]) == 64
    assert written["naming"]["top5"] == 0.58 and written["homes"]["homes"] == 1
    assert written["photographs"]["answers"][0]["truth"] == "cat"


def test_what_cannot_be_measured_is_left_out_in_a_sentence(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(encoder, "evaluate_homes", lambda *_: FOUND)
    monkeypatch.setattr(encoder.photographs.importlib.util, "find_spec", lambda name: None)
    encoder.main(["--json", str(tmp_path / "a.json")])
    printed = capsys.readouterr().out
    assert "pip install '.[assets]'" in printed and "pip install scikit-image" in printed
    assert json.loads((tmp_path / "a.json").read_text())["naming"] is None


def test_furniture_that_is_not_there_is_left_out_in_a_sentence(tmp_path):
    pytest.importorskip("numba")
    assert "apt-get install" in encoder.evaluate_naming(None, tmp_path, tmp_path)
    (tmp_path / "Other.sh3f").write_bytes(b"")
    assert "no BlendSwap-CC-0.sh3f" in encoder.evaluate_naming(None, tmp_path, tmp_path)


@pytest.mark.parametrize(("arguments", "words"), [(["--model", "nope"], "nope"), (["--homes", "0"], "at least 1")])
def test_a_mistake_is_told_in_a_sentence(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        encoder.main(arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_without_the_training_libraries_nothing_is_said_of_what_training_knew(capsys):
    nan = float("nan")
    naming = {"pictures": 3, "names": 2, "top1": 0.5, "top5": 1.0, "confusions": [("bed", "couch", 2)]}
    naming |= {"seen_top1": nan, "seen_top5": nan, "unseen_top1": 0.5, "unseen_top5": 1.0}
    encoder.show({"naming": naming, "homes": None, "photographs": None})
    printed = capsys.readouterr().out
    assert "nan" not in printed and "names it did not" not in printed and "bed with couch (2)" in printed
