"""``vlpg bench`` and ``vlpg-bench``: what they say, and their exit codes."""

import json
import shutil

import pytest

from edge.bench import __main__ as command
from edge.bench.overruns import BOARD, HOST
from edge.bench.probe_process import ProbeFailed
from edge.bench.report import Process, Report
from models.manifest import Manifest, resolve


def ended(arguments, **options):
    with pytest.raises(SystemExit) as stop:
        command.main(arguments, **options)
    return stop.value.code


@pytest.fixture
def measured(monkeypatch):
    """Measures nothing; the report has this peak."""
    peak = {BOARD: Process(150.0, 80.0, 70.0, 120.0, 160.0)}
    monkeypatch.setattr(command, "measure", lambda *_, **__: [Report("x", "m", 1, {}, dict(peak), {})])
    return peak


def test_within_the_budget(measured, capsys):
    assert ended(["store", "--budget", "pi-zero-2w"]) == 0
    assert "within the budget pi-zero-2w" in capsys.readouterr().out


def test_over_it(measured, capsys):
    measured[BOARD] = Process(180.0, 100.0, 80.0, 120.0, 190.0)
    assert ended(["store", "--budget", "pi-zero-2w"]) == 1
    assert "OVER  mission: peak PSS is 180.0 MB, over 170" in capsys.readouterr().out


def test_against_an_earlier_report(measured, tmp_path, capsys):
    file = tmp_path / "bench.json"
    assert ended(["store", "--json", str(file)]) == 0 and json.loads(file.read_text())["processes"]
    assert ended(["store", "--against", str(file)]) == 0
    measured[BOARD] = Process(160.0, 90.0, 70.0, 120.0, 170.0)
    assert ended(["store", "--against", str(file)]) == 1
    assert "160.0 MB, was 150.0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["mission"], "needs a --recording"),
        (["mission", "--recording", "/nowhere.rec"], "/nowhere.rec cannot be read"),
        (["store", "--model", "nope"], "nope"),
        (["store", "--against", "/nowhere.json"], "/nowhere.json cannot be read"),
        (["store", "--runs", "0"], "at least 1"),
        (["all", "--recording", "x", "--enforce"], "--enforce needs a --budget"),
        (["store", "--enforce", "100"], "only missions"),
        (["all", "--recording", "x", "--enforce", "-100"], "no limit"),
        (["all", "--recording", "x", "--enforce", "nan"], "no limit"),
        (["all", "--recording", "x", "--enforce", "abc"], "no limit"),
        (["all", "--recording", "x", "--enforce", "100", "--json", "x.json"], "--enforce says only"),
        (["encoder", "--budget", "pi-zero-2w"], "no budget limits encoder"),
        (["store", "--json", "/nowhere/x.json"], "there is no folder /nowhere"),
    ],
)
def test_a_mistake_is_told_in_a_sentence(arguments, words, capsys):
    assert ended(arguments) == 2 and words in capsys.readouterr().err


def test_enforced_with_enough_and_with_too_little(recording, capsys):
    assert ended(["mission", "--recording", str(recording), "--enforce", "250"]) == 0
    assert capsys.readouterr().out.count("finished") == 2
    assert ended(["mission", "--recording", str(recording), "--enforce", "40"]) == 1
    assert "OVER  mission under 40 MB" in capsys.readouterr().out


def test_a_mission_that_finishes_with_more_than_the_limit_is_over_it(monkeypatch, recording, capsys):
    monkeypatch.setattr(command, "weigh", lambda subject, limit: ({}, Process(101.0, 50.0, 51.0, 90.0, 110.0)))
    assert ended(["mission", "--recording", str(recording), "--enforce", "100"]) == 1
    assert "OVER  mission under 100 MB" in capsys.readouterr().out


def test_what_is_measured_is_kept_as_it_comes(monkeypatch, tmp_path):
    def measure(*_, **__):
        yield Report("x", "m", 1)
        raise ProbeFailed("the board went away")

    monkeypatch.setattr(command, "measure", measure)
    assert ended(["store", "--json", str(tmp_path / "bench.json")]) == 2
    assert Report.load(tmp_path / "bench.part").runs == 1 and not (tmp_path / "bench.json").exists()


def test_each_kind_of_mission_has_the_budgets_limit_for_it(monkeypatch, recording, capsys):
    monkeypatch.setattr(command, "weigh", lambda subject, limit: ({}, Process(99.0, 50.0, 49.0, 90.0, 110.0)))
    assert ended(["mission", "--recording", str(recording), "--budget", "pi-zero-2w", "--enforce"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("mission under 170 MB") and told[1].startswith("mission, text on the host under 130 MB")


def test_a_robot_without_a_text_tower_is_measured_as_with_a_host(recording, tmp_path, capsys):
    shipped, offloaded = Manifest.load(resolve()), tmp_path / "offloaded"
    offloaded.mkdir()
    for name in ["manifest.json", *(file.name for file in shipped.image_files)]:
        shutil.copy(shipped.folder / name, offloaded)
    model = ["--model", str(offloaded), "--runs", "1"]
    assert ended(["encoder", *model]) == 0
    told = capsys.readouterr()
    assert "without its text tower" in told.err and "Grad-CAM" in told.out and "prompt" not in told.out
    assert ended(["mission", "--recording", str(recording), *model]) == 0
    told = capsys.readouterr().out
    assert HOST in told and f"{BOARD}:" not in told
