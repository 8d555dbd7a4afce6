import os
import signal
import socket
import subprocess
import sys
import time

import psutil
import pytest

from tools.demo.processes import ProcessDied, Supervisor, free_port, module

SLEEP = [sys.executable, "-c", "import time; print('up', flush=True); time.sleep(60)"]
STUBBORN = [
    sys.executable,
    "-c",
    "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('up', flush=True); time.sleep(60)",
]


def _wait_for(condition, timeout=10.0):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(0.01)


def _gone(pid):
    return not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE


def test_children_end_with_the_block(tmp_path):
    with Supervisor(tmp_path) as processes:
        pids = [processes.start(name, SLEEP).pid for name in ("a", "b")]
        processes.watch(0.05)
        assert all(psutil.pid_exists(pid) for pid in pids)
    assert not any(psutil.pid_exists(pid) for pid in pids)


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_children_end_when_the_block_breaks_off(tmp_path, error):
    with pytest.raises(error), Supervisor(tmp_path) as processes:
        pid = processes.start("a", SLEEP).pid
        raise error
    assert not psutil.pid_exists(pid)


def test_a_child_that_does_not_listen_is_killed(tmp_path):
    with Supervisor(tmp_path) as processes:
        child = processes.start("a", STUBBORN)
        _wait_for(lambda: "up" in child.last_lines())
        child.stop(patience=0.1)
        assert child.exit_code == -signal.SIGKILL


def test_a_death_is_told_with_its_last_words(tmp_path):
    script = "import sys; print('starting'); sys.exit('the map is upside down')"
    with Supervisor(tmp_path) as processes:
        processes.start("robot", [sys.executable, "-c", script])
        with pytest.raises(ProcessDied, match=r"robot process ended with exit code 1(.|\n)*the map is upside down"):
            processes.watch(10.0)


def test_a_kill_is_told_by_the_signal(tmp_path):
    with Supervisor(tmp_path) as processes:
        child = processes.start("sim", SLEEP)
        os.kill(child.pid, signal.SIGKILL)
        with pytest.raises(ProcessDied, match="sim process was ended by SIGKILL"):
            processes.watch(10.0)


def test_children_do_not_outlive_a_killed_parent(tmp_path):
    script = (
        "import time, sys; from pathlib import Path; from tools.demo.processes import Supervisor\n"
        f"processes = Supervisor(Path({str(tmp_path)!r}))\n"
        f"print(processes.start('a', {SLEEP!r}).pid, flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as parent:
        pid = int(parent.stdout.readline())
        _wait_for(lambda: (tmp_path / "a.log").read_text() == "up\n")
        parent.kill()
    _wait_for(lambda: _gone(pid))


def test_ctrl_c_on_the_terminal_leaves_children_to_the_parent(tmp_path):
    with Supervisor(tmp_path) as processes:
        child = processes.start("a", SLEEP)
        assert os.getpgid(child.pid) != os.getpgid(0)


def test_a_module_of_the_current_folder_does_not_shadow_ours(tmp_path):
    (tmp_path / "tools.py").write_text("raise SystemExit('shadowed')")
    done = subprocess.run(module("tools.cli", "--help"), cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_free_port_can_be_listened_on():
    with socket.socket() as server:
        server.bind(("127.0.0.1", free_port()))
