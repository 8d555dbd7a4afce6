"""The processes themselves, as short as they get."""

import pytest

from edge.bench import measure as module
from edge.bench.measure import FOLDER, WEIGHED, Subject, measure, run, subjects, weigh
from edge.bench.overruns import BOARD, HOST
from edge.bench.probe_process import ProbeFailed
from edge.bench.recording import Recording, write
from edge.bench.report import Process
from models.manifest import DEFAULT


def test_all_is_each_of_the_others(recording):
    parts = [subjects(what, recording, DEFAULT) for what in ("encoder", "store", "planning", "mission")]
    assert subjects("all", recording, DEFAULT) == sum(parts, [])


@pytest.fixture(scope="module")
def missions(recording):
    return {subject.name: weigh(subject) for subject in subjects("mission", recording, DEFAULT)}


@pytest.mark.parametrize("name", [BOARD, HOST])
def test_a_mission_tells_its_stages_and_is_weighed(missions, name):
    said, process = missions[name]
    stages = said["stages"]
    assert len(stages["whole step"]) == 6 and len(stages["encode two prompts"]) == 1
    assert {"localize", "encode a picture", "offer a view to the memory", "recall and rank viewpoints"} <= set(stages)
    assert 60 < process.anonymous + process.file_backed == pytest.approx(process.peak, abs=0.2)
    assert process.steady <= process.peak <= process.rss
    memory, grid, disk = said["sizes"].values()
    assert 0 < memory < grid and 1 < disk < 100


def test_a_host_saves_the_memory_of_the_text_tower(missions):
    assert missions[BOARD][1].peak > missions[HOST][1].peak + 10


def test_what_a_host_was_not_asked_is_told(recording, tmp_path):
    write(tmp_path / "silent.rec", list(Recording(recording)), [(4, "couch")])
    with pytest.raises(ProbeFailed, match="host"):
        run(Subject("mission", "edge.bench.mission", (str(tmp_path / "silent.rec"), DEFAULT, "host", FOLDER)))


def test_planning_on_the_recorded_map(recording):
    said = run(Subject("planning", "edge.bench.planning", (str(recording),)))
    assert set(said["stages"]) >= {"plan a way", "control", "rank viewpoints", "find frontiers"}
    assert all(call > 0 for calls in said["stages"].values() for call in calls)


def test_it_is_repeated_until_the_medians_are_close(monkeypatch):
    medians = iter([10.0, 12.0, 11.0, 11.0, 11.0, 11.0, 11.0, 11.0, 11.0])
    weights = iter(range(100, 200))

    def heavy(subject):
        return {"stages": {"s": [99.0]}, "sizes": {}}, Process(next(weights), 0, 0, 0, 0)

    monkeypatch.setattr(module, "weigh", heavy)
    monkeypatch.setattr(module, "run", lambda subject: {"stages": {"s": [next(medians)] * 30}})
    (report,) = measure([Subject("x", "m", ())], DEFAULT, tell=lambda line: None)
    assert 3 < report.runs < 9 and report.stages["x: s"].interval <= 0.05 * 11.0
    assert report.processes["x"].peak == 100 + WEIGHED - 1  # the heaviest; its times do not count


def test_what_happens_a_few_times_a_run_does_not_keep_it_going(monkeypatch):
    times = iter([10.0, 20.0, 30.0])
    monkeypatch.setattr(module, "weigh", lambda subject: ({"stages": {}, "sizes": {}}, Process(100, 0, 0, 0, 0)))
    monkeypatch.setattr(module, "run", lambda subject: {"stages": {"s": [next(times)] * 2, "t": [5.0] * 30}})
    assert [report.runs for report in measure([Subject("x", "m", ())], DEFAULT, tell=lambda line: None)] == [3]
