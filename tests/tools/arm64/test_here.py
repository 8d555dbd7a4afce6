"""The comparison of two processors' results; the emulated one is tools/arm64_check.sh's."""

import sys

import numpy as np
import pytest

from edge.memory.store import Vlpg
from edge.perception.encoder import Encoder
from tools.arm64 import here

RESULTS = {
    "vectors": np.eye(4)[None],
    "direction": np.array([1.0, 0.0]),
    "ids": np.arange(20),
    "commands": np.zeros((5, 2)),
    "poses": np.zeros((5, 3)),
    "status": np.array("found"),
    "seen": np.array([1.0, 2.0]),
}


@pytest.fixture
def folder(tmp_path):
    encoder = Encoder.load(text=False)
    with Vlpg.open(tmp_path / "there.vlpg", encoder.name, encoder.digest, encoder.dim) as memory:
        vectors = np.eye(1, encoder.dim, dtype=np.float32)
        memory.add(0.0, np.zeros(3), np.eye(3), vectors, np.zeros(1))
    np.savez(tmp_path / "here.npz", **RESULTS)
    return tmp_path


def verdicts(folder, **changed):
    np.savez(folder / "there.npz", **(RESULTS | changed))
    return {subject: good for subject, _, good in here.compare(folder)}


def test_the_same_is_well(folder):
    assert all(verdicts(folder).values())


@pytest.mark.parametrize(
    ("changed", "subject"),
    [
        ({"vectors": np.roll(np.eye(4), 1, 0)[None]}, "int8 picture vectors"),
        ({"direction": np.array([0.9, 0.1])}, "int8 text direction"),
        ({"ids": np.arange(20)[::-1]}, "hits in a store made here"),
        ({"poses": np.full((5, 3), 0.1)}, "poses believed"),
        ({"commands": np.full((5, 2), 0.5)}, "commands"),
        ({"status": np.array("not found")}, "the search's end"),
        ({"seen": np.array([1.0, 3.0])}, "the object in the last picture"),
        ({"seen": np.full(2, np.nan)}, "the object in the last picture"),
    ],
)
def test_a_difference_is_told(folder, changed, subject):
    found = verdicts(folder, **changed)
    assert not found.pop(subject) and all(found.values())


def test_a_search_that_the_recording_cuts_off_is_no_other_end(folder):
    assert verdicts(folder, status=np.array("under way"))["the search's end"]


def test_the_exit_code(folder, monkeypatch, capsys):
    np.savez(folder / "there.npz", **(RESULTS | {"status": np.array("timeout")}))
    monkeypatch.setattr(sys, "argv", ["here", "compare", str(folder)])
    with pytest.raises(SystemExit) as ended:
        here.main()
    assert ended.value.code == 1 and "found here, timeout there" in capsys.readouterr().out
