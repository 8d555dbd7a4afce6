import pytest

from firmware_sim.house import HouseError
from tools.eval.campaign import Plan, chosen
from tools.eval.find import main, show_home
from tools.eval.options import homes_named
from tools.eval.spread import digest_of_code, load, run_homes, save

PLAN = Plan(encoder="oracle", objects=1)


def test_objects_are_drawn_by_lot_once_and_for_all(tour):
    assert len(chosen(tour, PLAN)) == 1 and chosen(tour, PLAN) == chosen(tour, PLAN)
    assert chosen(tour, Plan(encoder="oracle")) == ["armchair", "couch", "dustbin", "teddy bear"]


def test_a_home_is_run_once_and_then_read(home, tmp_path, monkeypatch):
    (first,) = run_homes([home], PLAN, 1, tmp_path)
    assert len(first.episodes) == 1 and first.episodes[0].success
    assert first.dense > 60 * first.memory > 0
    (file,) = tmp_path.glob("two-rooms.oracle.*.json")
    save(load(file, PLAN), tmp_path / "copy.json", digest_of_code())
    assert (tmp_path / "copy.json").read_text() == file.read_text()
    monkeypatch.setattr(Plan, "run", None)  # would fail if it were asked
    (again,) = run_homes([home], PLAN, 1, tmp_path)
    assert show_home(again) == show_home(first)


def test_a_cluster_gives_the_same(home):
    pytest.importorskip("ray")
    (alone,), (there,) = run_homes([home], PLAN, 1), run_homes([home], PLAN, 1, cluster="local")
    assert show_home(there) == show_home(alone)


def test_homes_are_named_in_three_ways():
    assert homes_named("handmade") == ["apartment", "bungalow", "cottage"]
    assert homes_named("generated:3-5,cottage") == ["generated:3", "generated:4", "generated:5", "cottage"]
    with pytest.raises(HouseError, match="no range"):
        homes_named("generated:5-3")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--methods", "magic"], "no method magic"),
        (["--disturb", "flood"], "no disturbance flood"),
        (["--truth", "wheels"], "no part wheels"),
        (["--objects", "0"], "at least 1"),
        (["--homes", "castle"], "castle"),
        (["--seed", "-1"], "no seed"),
        (["--picture", "chart.xyz"], "end it in .png"),
        (["--out", __file__], "is a file"),
    ],
)
def test_a_mistake_is_told_in_a_sentence(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        main([*arguments, "--jobs", "1"])
    assert ended.value.code == 2
    assert words in capsys.readouterr().err
