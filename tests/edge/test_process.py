import os
import platform
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from edge.process import MemoryUse, _of_files_alone, cache_file, pss, stop_event


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


def test_a_signal_amid_a_wait_does_not_lock_up():
    event = stop_event()
    with event._cond:  # as whoever waits has it now and then
        signal.raise_signal(signal.SIGTERM)
    assert event.wait(5)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc keeps large blocks")
def test_large_blocks_are_given_back():
    script = """
import ctypes, sys
from edge.process import give_back_large_blocks, pss
libc = ctypes.CDLL(None)
libc.malloc.restype, libc.malloc.argtypes, libc.free.argtypes = ctypes.c_void_p, [ctypes.c_size_t], [ctypes.c_void_p]
if sys.argv[1] == "yes":
    give_back_large_blocks()
libc.free(libc.malloc(2_000_000))  # by this, glibc would learn that such blocks belong on the heap
before, large = pss(), []
for _ in range(50):
    large.append(libc.malloc(1_000_000))
    ctypes.memset(large[-1], 1, 1_000_000)
    libc.malloc(5_000)  # stays, after each
for block in large[:-1]:
    libc.free(block)
libc.malloc(5_000)
print(pss() - before)
"""
    kept = [
        float(subprocess.run([sys.executable, "-c", script, asked], capture_output=True, text=True, check=True).stdout)
        for asked in ("no", "yes")
    ]
    assert kept[0] > 40 and kept[1] < 5


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({"XDG_CACHE_HOME": "/somewhere", "HOME": "/home/me"}, Path("/somewhere/vlpg/a.db")),
        ({"XDG_CACHE_HOME": "relative", "HOME": "/home/me"}, Path("/home/me/.cache/vlpg/a.db")),
        ({"HOME": "/home/me"}, Path("/home/me/.cache/vlpg/a.db")),
        ({"HOME": "nowhere"}, None),
    ],
)
def test_the_cache_is_where_the_xdg_specification_says(monkeypatch, environment, expected):
    for name in ("XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert cache_file("a.db") == expected


@pytest.mark.skipif(sys.platform != "linux", reason="/proc")
def test_what_loading_took_is_given_back_and_all_still_works():
    script = """
import re, sys
import cv2, numpy as np, onnxruntime, zenoh
from edge.process import give_back_what_loading_took
def resident():
    text = open("/proc/self/smaps_rollup").read()
    return [int(re.search(rf"^{name}: +(\\d+)", text, re.M)[1]) / 1000 for name in ("Rss", "Anonymous")]
before, own = resident()
give_back_what_loading_took()
after, kept = resident()
picture = np.random.default_rng(0).integers(0, 255, (240, 320, 3), np.uint8)
assert cv2.imdecode(cv2.imencode(".png", picture)[1], 1).tobytes() == picture.tobytes()
assert zenoh.Config() and onnxruntime.get_available_providers() and np.linalg.inv(np.eye(3)).sum() == 3
print(before - after, abs(own - kept))
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    given, lost = (float(word) for word in run.stdout.split())
    assert given > 10 and lost < 1


def test_only_clean_pages_of_files_are_given_back():
    entry = "{span} {mode} 00000000 fe:00 12 {name}\nSize: 8 kB\nRss: 8 kB\nAnonymous: {own} kB\nVmFlags: rd\n"
    smaps = "".join(
        entry.format(span=f"{number}000-{number + 1}000", mode=mode, name=name, own=own)
        for number, (mode, name, own) in enumerate(
            [
                ("r-xp", "/lib/a.so", 0),
                ("r-xp", "/lib/a.so", 4),
                ("rw-p", "/lib/a.so", 0),
                ("r--p", "/weights", 0),
                ("r-xp", "", 0),
                ("r-xp", "[vdso]", 0),
            ],
            start=1,
        )
    )
    assert list(_of_files_alone(smaps)) == [(0x1000, 0x2000), (0x4000, 0x5000)]
