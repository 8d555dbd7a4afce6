import subprocess
import sys
import time

import psutil
import pytest

from edge.bench.usage import Sampler, read_usage

HOLD = "import sys; block = bytearray(b'x' * {size}); print('ready', flush=True); sys.stdin.read()"


@pytest.fixture
def holder():
    """A process that holds 40 MB."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLD.format(size=40_000_000)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout.readline() == b"ready\n"
        yield process
        process.stdin.close()


def test_agrees_with_psutil(holder):
    usage = read_usage(holder.pid)
    full = psutil.Process(holder.pid).memory_full_info()
    assert usage.pss == pytest.approx(full.pss / 1e6, rel=0.02)
    assert usage.rss == pytest.approx(full.rss / 1e6, rel=0.02)


def test_splits_into_anonymous_and_file_backed(holder):
    usage = read_usage(holder.pid)
    assert usage.anonymous > 40
    assert usage.file_backed > 0
    assert usage.anonymous + usage.file_backed == pytest.approx(usage.pss, abs=0.01)


def test_a_process_that_is_gone_has_no_usage(holder):
    holder.kill()
    holder.wait()
    assert read_usage(holder.pid) is None


def test_a_zombie_has_no_usage(holder):
    holder.kill()
    deadline = time.monotonic() + 5
    while psutil.Process(holder.pid).status() != psutil.STATUS_ZOMBIE and time.monotonic() < deadline:
        time.sleep(0.01)
    assert read_usage(holder.pid) is None


def test_the_sampler_keeps_peaks_and_survives_a_death(holder):
    with Sampler({"holder": holder.pid, "nobody": 2**22 + 1}, period=0.02) as sampler:
        time.sleep(0.15)
        holder.kill()
        holder.wait()
        time.sleep(0.1)
    history = sampler.histories["holder"]
    assert len(history.usages) >= 3
    assert history.peak.pss == max(usage.pss for usage in history.usages) > 40
    assert history.times == sorted(history.times)
    assert sampler.histories["nobody"].peak is None
