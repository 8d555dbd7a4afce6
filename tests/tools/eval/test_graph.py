import numpy as np
import pytest

from tools.eval import graph
from tools.eval.graph import main, straighten


def test_a_small_home_is_straightened_without_harm(home):
    found = straighten(home, "oracle", 0)
    assert found.nodes > 15 and found.raw[0] < 0.5
    assert found.optimised[0] < found.raw[0] + 0.05 and np.isfinite(found.optimised).all()


def test_what_the_optimiser_finds_is_what_is_judged(home, monkeypatch):
    def a_metre_off(ids, poses, edges, transforms, information, trusted):
        assert len(ids) == len(poses) and len(edges) >= len(ids) - 1
        return poses + [0.0, 1.0, 0.0], None

    monkeypatch.setattr(graph, "optimise", a_metre_off)
    found = straighten(home, "oracle", 0)
    assert found.optimised[0] == pytest.approx(1.0, abs=found.raw[0] + 0.01) and found.optimised[1] == found.raw[1]


def test_a_mistake_is_told_in_a_sentence(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["castle", "--encoder", "oracle"])
    assert ended.value.code == 2 and "castle" in capsys.readouterr().err


def test_prints_a_line_a_home(monkeypatch, capsys):
    monkeypatch.setattr(
        graph, "straighten", lambda home, *_: graph.Straightened(home, 99, 7, (0.2, 0.01), (0.08, 0.005))
    )
    main(["cottage"])
    line = capsys.readouterr().out.splitlines()[-1]
    assert line.split()[:3] == ["cottage", "99", "7"] and "0.200 m" in line and "0.080 m" in line
