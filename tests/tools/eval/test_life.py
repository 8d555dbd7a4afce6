"""A small home, of which one thing is moved, one taken away and one brought in between two tours."""

import json

import pytest

from edge.memory.store import VlpgConfig
from tools.eval import life
from tools.eval.life import Answer, Visit, live, main, show


@pytest.fixture(scope="module")
def visits(home):
    return list(live(home, "oracle", tours=2, changes=1, seed=2, limit=VlpgConfig.limit))


def of_kind(visit, kind):
    return [answer for answer in visit.answers if answer.kind == kind]


def test_a_second_tour_teaches_what_has_changed(visits):
    first, second = visits
    assert first.complete and second.complete and first.tour == 1 and second.tour == 2
    assert [len(of_kind(first, kind)) for kind in life.KINDS] == [4, 0, 0, 0]
    assert [len(of_kind(second, kind)) for kind in life.KINDS] == [2, 1, 1, 1]
    assert all(answer.remembered for answer in first.answers)
    assert all(answer.right for kind in ("added", "removed") for answer in of_kind(second, kind))
    assert all(answer.remembered for kind in ("unchanged", "moved", "added") for answer in of_kind(second, kind))
    assert all(answer.toured == (answer.kind != "removed") for answer in second.answers)


def test_a_visit_tells_what_the_memory_weighs_and_how_true_it_is(visits):
    first, second = visits
    assert 15 < first.answering <= first.nodes < second.nodes and second.limit == VlpgConfig.limit
    assert 0 < first.ram and 100_000 < first.disk < second.disk
    assert all(0 < error < 0.2 for visit in visits for error in visit.error)


def test_a_small_store_stays_within_its_limit_and_still_knows_most(home):
    (visit,) = live(home, "oracle", tours=1, changes=0, seed=0, limit=15)
    assert visit.answering == visit.limit == 15 and visit.nodes < 60
    assert sum(answer.right for answer in visit.answers) >= 3


def answer(noun, kind, right=True, stale=False):
    return Answer(noun, kind, True, True, right, right, stale)


def test_the_table_counts_of_what_lasted_only_what_lasted():
    def visit(tour, *answers):
        return Visit("flat", tour, True, 60.0, 50, 60, 99, 10**6, 10**7, (0.03, 0.02), list(answers))

    sofa, gone = answer("sofa", "unchanged"), answer("vase", "removed")
    first = visit(1, answer("cup", "unchanged"), sofa, answer("vase", "unchanged", right=False))
    second = visit(2, answer("cup", "moved", right=False, stale=True), sofa, gone)
    lines = [line.split() for line in show([first, second]).splitlines()]
    assert lines[1][:4] == ["unchanged", "1", "of", "1"]
    assert ["moved", "0", "of", "1", "right,", "0", "in", "the", "first", "three,", "1"] == lines[4][:11]


def test_a_mistake_is_told_in_a_sentence(capsys):
    for wrong in ("--homes castle", "--tours 0", "--limit 0"):
        with pytest.raises(SystemExit) as ended:
            main([*wrong.split(), "--encoder", "oracle"])
        assert ended.value.code == 2 and wrong.split()[wrong == "--homes castle"] in capsys.readouterr().err


def test_prints_a_line_a_visit_and_keeps_all_answers(monkeypatch, capsys, tmp_path):
    visit = Visit("flat", 1, True, 60.0, 50, 60, 99, 10**6, 10**7, (0.03, 0.02), [answer("cup", "unchanged")])
    monkeypatch.setattr(life, "live", lambda *_: [visit])
    main(["--homes", "flat", "--json", str(tmp_path / "life.json")])
    output = capsys.readouterr().out
    assert "50 nodes answer, of 60 (limit 99)" in output and "unchanged" in output
    assert json.loads((tmp_path / "life.json").read_text())[0]["answers"][0]["noun"] == "cup"
