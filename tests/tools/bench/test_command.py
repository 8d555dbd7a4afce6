"""Who answers ``vlpg bench``."""

import sys

import pytest

from models.manifest import DEFAULT, Manifest, resolve
from tools.bench import command, record


@pytest.fixture
def called(monkeypatch):
    """What was called, and with what."""
    calls = []
    monkeypatch.setattr(record, "main", lambda others: calls.append(("record", others)))
    monkeypatch.setattr(command, "bench", lambda arguments, *_: calls.append(("bench", arguments)))
    monkeypatch.setattr(command, "PEERS", {"store": lambda others: calls.append(("store", others))})
    return calls


@pytest.mark.parametrize(
    ("words", "answered"),
    [
        ("record a.rec --seed 3", ("record", ["a.rec", "--seed", "3"])),
        ("peers store --turns 2", ("store", ["--turns", "2"])),
        ("all --budget pi-zero-2w", ("bench", ["all", "--budget", "pi-zero-2w"])),
        ("--help", ("bench", ["--help"])),
    ],
)
def test_each_has_its_own_arguments(monkeypatch, called, words, answered):
    monkeypatch.setattr(sys, "argv", ["bench", *words.split()])
    command.main()
    assert called == [answered]


@pytest.mark.parametrize("words", ["peers", "peers magic"])
def test_peers_of_nobody(monkeypatch, called, words):
    monkeypatch.setattr(sys, "argv", ["bench", *words.split()])
    with pytest.raises(SystemExit, match="encoder or store"):
        command.main()
    assert not called


def test_the_usual_recording_is_made_once(monkeypatch, tmp_path):
    made = []

    def pretend(path, home, objects, model):
        made.append((home, model))
        path.write_bytes(b"")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(record, "record", pretend)
    (tmp_path / "vlpg").mkdir()
    file = tmp_path / "vlpg" / f"bench-{Manifest.load(resolve()).digest[:12]}.rec"
    assert command.usual_recording(DEFAULT) == command.usual_recording(DEFAULT) == file
    assert made == [(record.HOME, DEFAULT)]
