import json

import pytest

from models.manifest import Manifest, resolve
from tools.bench import encoder
from tools.bench.peers import Peer


def test_a_peer_that_is_not_installed_is_left_out_in_a_sentence(monkeypatch, tmp_path):
    monkeypatch.setattr(encoder.importlib.util, "find_spec", lambda name: None)
    commands, missing = encoder.peers(Manifest.load(resolve()), tmp_path)
    assert list(commands) == [encoder.OURS]
    assert "pip install onnx" in missing[0] and ".[train]" in missing[1]


def test_the_table_and_the_file_say_the_same(monkeypatch, tmp_path, capsys):
    peers = [Peer(encoder.OURS, 6.0, 5.5, 7.0, 1.0, 70.1, 42.0, 28.1)]
    monkeypatch.setattr(encoder, "measure", lambda commands, turns: peers)
    monkeypatch.setattr(encoder.importlib.util, "find_spec", lambda name: None)
    encoder.main(["--json", str(tmp_path / "bench.json")])
    printed = capsys.readouterr().out
    for figure in ("6.00 ms", "1.00x", "70.1 MB", "42 + 28 MB", "left out"):
        assert figure in printed
    assert json.loads((tmp_path / "bench.json").read_text())[0]["peak"] == 70.1


@pytest.mark.parametrize(("arguments", "words"), [(["--model", "nope"], "nope"), (["--turns", "0"], "at least 1")])
def test_a_mistake_is_told_in_a_sentence(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        encoder.main(arguments)
    assert ended.value.code == 2 and words in capsys.readouterr().err
