"""Figures of several processes, against scipy, and their file."""

import numpy as np
import pytest
import scipy.stats

from edge.bench.report import Process, Report, ReportError, Stage


@pytest.mark.parametrize("count", [2, 3, 10])
def test_the_interval_is_students(count):
    runs = [np.random.default_rng(seed).gamma(2.0, 1.0, 50).tolist() for seed in range(count)]
    stage = Stage.of(runs)
    medians = [np.median(run) for run in runs]
    low, high = scipy.stats.t.interval(0.95, count - 1, np.mean(medians), scipy.stats.sem(medians))
    assert stage.interval == pytest.approx((high - low) / 2, rel=2e-3)
    together = np.concatenate(runs)
    assert (stage.p50, stage.max) == pytest.approx((np.median(together), together.max()), abs=1e-4)
    assert stage.p95 == pytest.approx(np.percentile(together, 95), abs=1e-4) and stage.calls == 50 * count


def test_one_process_has_no_interval():
    assert np.isnan(Stage.of([[1.0, 2.0, 3.0]]).interval)


@pytest.fixture
def report():
    stages = {"encoder: encode a picture": Stage(8.0, 9.0, 12.0, 8.1, 0.2, 300)}
    return Report("x", "m", 3, stages, {"mission": Process(150.0, 80.0, 70.0, 120.0, 160.0)}, {"store: RAM": 1.2})


def test_it_is_read_as_it_was_saved(report, tmp_path):
    report.save(tmp_path / "bench.json")
    assert Report.load(tmp_path / "bench.json") == report


def test_the_table_has_every_figure(report):
    for figure in ("8.00", "0.20", "9.00", "12.00", "150.0", "80.0 + 70.0", "120.0", "160.0", "1.20"):
        assert figure in str(report)


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"stages": {"a": {"b": 1}}, "processes": {}}'])
def test_another_file_is_told_in_a_sentence(tmp_path, content):
    (tmp_path / "other.json").write_text(content)
    with pytest.raises(ReportError, match="no report of this benchmark"):
        Report.load(tmp_path / "other.json")


def test_a_missing_file_is_told_in_a_sentence(tmp_path):
    with pytest.raises(ReportError, match="cannot be read"):
        Report.load(tmp_path / "nowhere.json")
