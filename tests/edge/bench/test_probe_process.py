import os
import signal

import psutil
import pytest

from edge.bench.probe_process import ProbeFailed, ProbeProcess
from models.manifest import resolve


def test_it_times_and_weighs_a_process_of_its_own():
    with ProbeProcess("tools.models.probe", "image", str(resolve())) as probe:
        alone = psutil.Process(probe._process.pid).memory_full_info()
        times = probe.time(3)
        pid = probe._process.pid
    assert len(times) == 3 and all(0 < time < 5 for time in times)
    # Independent: not less than what is the process's alone, not more than all that it has mapped.
    assert alone.uss / 1e6 * 0.9 < probe.peak.pss <= probe.peak.rss * 1.01
    assert probe.peak.pss == pytest.approx(probe.peak.anonymous + probe.peak.file_backed, abs=1)
    assert not psutil.pid_exists(pid)


def test_a_process_that_also_has_the_libraries_does_not_make_it_lighter():
    """Of pages that two processes map, PSS charges each with half."""
    with ProbeProcess("tools.models.probe", "image", str(resolve())) as first:
        with ProbeProcess("tools.models.probe", "image", str(resolve())) as second:
            assert second.peak.pss == pytest.approx(first.peak.pss, rel=0.1)
            raw = psutil.Process(second._process.pid).memory_full_info().pss / 1e6
    assert raw < second.peak.pss


def test_that_it_was_killed_is_told():
    with pytest.raises(ProbeFailed, match="signal 9"):
        ProbeProcess("timeit", limit=lambda: os.kill(os.getpid(), signal.SIGKILL))


def test_why_it_ended_is_told():
    with pytest.raises(ProbeFailed, match="no model in /nowhere"):
        ProbeProcess("tools.models.probe", "image", "/nowhere")
