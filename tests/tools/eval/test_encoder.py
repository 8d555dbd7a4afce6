import pytest

from tools.eval import encoder
from tools.train.evaluate import HOMES


def test_prints_what_was_measured(monkeypatch, capsys):
    asked = []

    def measured(model, seeds):
        asked.append((model.name, seeds))
        return {"queries": 41, "first": 0.25, "within10": 0.6, "sightings": 234, "pointing": 0.4, "iou": 0.2}

    monkeypatch.setattr(encoder, "evaluate_homes", measured)
    encoder.main(["--homes", "2"])
    assert asked == [("lite0-minilm", range(HOMES.start, HOMES.start + 2))]
    printed = capsys.readouterr().out
    for figure in ("41 names", "25.0%", "60.0%", "234 things", "40.0%", "20.0%"):
        assert figure in printed


@pytest.mark.parametrize(("arguments", "words"), [(["--model", "nope"], "nope"), (["--homes", "0"], "at least 1")])
def test_a_mistake_is_told_in_a_sentence(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        encoder.main(arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err
