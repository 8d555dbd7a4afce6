"""What grew since an earlier report."""

import pytest

from edge.bench.baseline import regressions
from edge.bench.report import Process, Report, ReportError, Stage


def report(p50=10.0, interval=0.1, peak=100.0, size=1.0):
    stages = {"encoder: encode": Stage(p50, p50, p50, p50, interval, 9)}
    return Report("x", "m", 3, stages, {"mission": Process(peak, 0, 0, 0, 0)}, {"store: RAM": size})


def test_noise_and_gains_are_not_told():
    assert regressions(report(p50=11.4, peak=102.9, size=1.02), report()) == []
    assert regressions(report(p50=5.0, peak=50.0, size=0.5), report()) == []


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"p50": 11.6}, "encoder: encode takes 11.60 ms, was 10.00"),
        ({"peak": 103.1}, "peak PSS is 103.1 MB, was 100.0"),
        ({"size": 1.04}, "is 1.04 MB, was 1.00"),
    ],
)
def test_what_grew_is_told(changed, words):
    (problem,) = regressions(report(**changed), report())
    assert words in problem


def test_two_wide_intervals_hide_what_lies_in_them():
    assert regressions(report(p50=12.0, interval=1.5), report(interval=1.0)) == []


def test_microseconds_are_not_told():
    assert regressions(report(p50=0.05, interval=0.0), report(p50=0.02, interval=0.0)) == []


def test_what_is_new_has_nothing_to_be_compared_with():
    assert regressions(report(), Report("x", "m", sizes={"store: RAM": 1.0})) == []


def test_a_report_of_other_parts_is_no_baseline():
    with pytest.raises(ReportError, match="nothing of what was measured"):
        regressions(report(), Report("x", "m", sizes={"store: disk": 1.0}))
