import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from edge.process import MemoryUse, pss


def test_pss_lies_between_the_unique_and_the_resident_set():
    status = Path("/proc/self/status").read_text()
    resident = int(re.search(r"VmRSS:\s+(\d+)", status)[1]) * 1024 / 1e6
    assert 5 < pss() <= resident * 1.1


def test_the_peak_is_kept_and_readings_are_rare(monkeypatch):
    readings = iter([50.0, 80.0, 60.0])
    monkeypatch.setattr("edge.process.pss", lambda: next(readings))
    use = MemoryUse()
    use.sample()
    assert (use.now, use.peak) == (50.0, 50.0)
    for _ in range(2):
        use._next = 0.0
        use.sample()
    assert (use.now, use.peak) == (60.0, 80.0)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_a_wait(number):
    script = """
from edge.process import stop_event
event = stop_event()
print("up", flush=True)
event.wait(30)
print(event.is_set())
"""
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "up\n"
    os.kill(process.pid, number)
    assert process.communicate(timeout=10)[0] == "True\n" and process.returncode == 0
