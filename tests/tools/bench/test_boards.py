"""The estimate for boards: its arithmetic, and what it says."""

import pytest

from edge.bench.report import Process, Report, Stage
from tools.bench.boards import A53, BOARDS, MACS, Board, main, step


def stage(mean, calls):
    return Stage(mean, mean, mean, mean, 0.1, calls)


@pytest.fixture
def report():
    """100 steps of 30 ms on average, in which 150 pictures took 10 ms each."""
    stages = {
        "mission: whole step": stage(30.0, 100),
        "mission: encode a picture": stage(10.0, 150),
        "mission: Grad-CAM": stage(2.0, 50),
        "mission: encode two prompts": stage(100.0, 1),
        "mission: control": stage(5.0, 90),
    }
    return Report("x", "lite0-minilm", 3, stages, {"mission": Process(1, 1, 0, 1, 1)}, {})


def test_towers_and_the_rest_are_scaled_apart(report):
    slow = Board("slow", "Cortex-A53", A53.clock, A53, 500.0)
    one, four = slow.tower(1), slow.tower(4)
    assert four == pytest.approx(30.0 * MACS / 300) and one == pytest.approx(3 * four)
    # 17 of the 30 ms are the towers', the other 13 are on a core with a fourth of the rating.
    assert step(report, 2000.0, slow, 1) == pytest.approx(17.0 * one / 10.0 + 13.0 * 4)


def test_a_faster_clock_is_faster():
    assert Board("x", "y", 2.8, A53, 1.0).tower(1) == pytest.approx(Board("x", "y", 1.4, A53, 1.0).tower(1) / 2)


def test_the_table_says_that_it_is_an_estimate(report, tmp_path, capsys):
    report.save(tmp_path / "today.json")
    main([str(tmp_path / "today.json"), "--mips", "3500"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("ESTIMATES, not measured") and len(lines) == 3 + len(BOARDS)
    assert {"Cortex-A53", "Cortex-A72", "Cortex-A76"} == {line[23:33] for line in lines[3:]}


@pytest.mark.parametrize(
    ("change", "arguments", "words"),
    [
        (lambda report: report.stages.clear(), ["--mips", "3500"], "no stage 'mission: whole step'"),
        (lambda report: setattr(report, "model", "other"), ["--mips", "3500"], "only lite0-minilm"),
        (lambda report: None, ["--mips", "0"], "more than 0"),
        (lambda report: None, [], "--mips"),
    ],
)
def test_a_mistake_is_told_in_a_sentence(report, tmp_path, change, arguments, words, capsys):
    change(report)
    report.save(tmp_path / "today.json")
    with pytest.raises(SystemExit) as ended:
        main([str(tmp_path / "today.json"), *arguments])
    assert ended.value.code == 2 and words in capsys.readouterr().err
