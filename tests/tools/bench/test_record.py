"""What is written of a tour and searches; the missions themselves are tested elsewhere."""

import pytest

from edge.bench.recording import Recording
from edge.missions.mission import Mission
from edge.observation import Twist
from edge.perception.prompts import contrast
from tools.bench import record as module

FLAT = str(module.Path(__file__).parents[3] / "tools/arm64/flat.json")


class Short(Mission):
    """Turns for three steps."""

    def __init__(self, robot, target=None, search_unknown=False):
        super().__init__(robot)

    def story(self):
        for _ in range(3):
            yield Twist(0.0, 0.5)
        return "done"


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(module, "MapHome", Short)
    monkeypatch.setattr(module, "FindObject", Short)


def test_each_search_begins_where_the_mission_before_ended(short, tmp_path):
    module.main([str(tmp_path / "a.rec"), "--home", FLAT, "--objects", "plant", "bookcase"])
    recording = Recording(tmp_path / "a.rec")
    stamps = [seen.stamp for seen in recording]
    assert recording.questions == [(4, "plant"), (8, "bookcase")] and len(recording) == 12
    assert stamps == sorted(set(stamps))
    assert set(recording.prompts) == {*contrast("plant"), *contrast("bookcase")}
    assert all(vector.shape == (384,) for vector in recording.prompts.values())


def test_mistakes_are_told_in_a_sentence(tmp_path, capsys):
    for arguments in (["--home", "castle"], ["--model", "nope"]):
        with pytest.raises(SystemExit) as ended:
            module.main([str(tmp_path / "a.rec"), *arguments])
        assert ended.value.code == 2
    assert not list(tmp_path.iterdir())
