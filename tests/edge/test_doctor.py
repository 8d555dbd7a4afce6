"""What the doctor sees, and what it prescribes."""

import os
import sqlite3
import subprocess
import sys
import threading

import pytest

from edge import doctor
from edge.link import messages
from edge.link.session import LinkConfig, open_session
from edge.link.topic import publisher
from edge.memory.store import Vlpg
from models.manifest import Manifest, resolve


def test_this_machine_can_run_the_robot_and_the_model_is_sound():
    environment = {"ORT_DISABLE_TELEMETRY": "1", "OPENBLAS_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"}
    done = subprocess.run(
        [sys.executable, "-m", "edge.doctor", "--no-link"], capture_output=True, text=True, timeout=60, env=environment
    )
    lines = done.stdout.splitlines()
    assert not [line for line in lines if "BAD" in line and not line.startswith(("memory", "disk"))], done.stdout
    assert sum(line.startswith("package") for line in lines) == len(doctor.PACKAGES) + 1
    assert any(line.startswith("image tower  cosine 0.99") for line in lines) and "Traceback" not in done.stderr


def test_settings_of_an_unprepared_shell_are_told(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    bad = [finding for finding in doctor.machine(text=True) if finding.subject == "setting" and finding.remedy]
    assert any("export OPENBLAS_NUM_THREADS=1" in finding.remedy for finding in bad)


@pytest.mark.parametrize(("text", "robot", "enough"), [(True, False, False), (False, False, True), (True, True, True)])
def test_a_robot_that_runs_here_does_not_take_its_own_memory_away(monkeypatch, tmp_path, text, robot, enough):
    """The process in the service's control group is this one, which has more than 20 MB for itself."""
    monkeypatch.setattr(doctor, "CGROUPS", tmp_path)
    service = tmp_path / "system.slice" / "vlpg-robot.service"
    service.mkdir(parents=True)
    (service / "cgroup.procs").write_text(f"{os.getpid()}\n" if robot else "")
    monkeypatch.setattr(doctor, "_available", lambda: 180.0)
    (memory,) = [finding for finding in doctor.machine(text) if finding.subject == "memory"]
    assert bool(memory.remedy) != enough


def test_a_kernel_that_keeps_no_limit_is_told(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor, "CGROUPS", tmp_path)
    for controllers in ("cpu pids", "cpu memory pids"):
        (tmp_path / "cgroup.controllers").write_text(controllers)
        found = [finding for finding in doctor.machine(True) if finding.subject == "memory limit"]
        assert bool(found) == ("memory" not in controllers)
        assert all("cgroup_enable=memory" in finding.remedy for finding in found)


def test_a_slow_board_is_told_what_that_means_and_only_a_hopeless_one_is_bad(monkeypatch):
    for step, too_long, bad in ((100.0, 1000.0, False), (0.1, 1000.0, False), (0.1, 0.2, True)):
        monkeypatch.setattr(doctor, "STEP", step)
        monkeypatch.setattr(doctor, "TOO_LONG", too_long)
        (speed,) = [finding for finding in doctor.model(None, text=False) if "ms a picture" in finding.found]
        assert bool(speed.remedy) == bad and ("less often" in speed.found) == (step < 1)


def test_a_model_that_is_not_whole(tmp_path):
    (finding,) = doctor.model(str(tmp_path / "none"), text=True)
    assert "no model named" in finding.remedy


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-such-thing"))
    good, bad = doctor.packages(text=False)
    assert not good.remedy and "no-such-thing is missing" in bad.found and "install" in bad.remedy


@pytest.mark.parametrize("missing", ["zenoh", "numpy", "cv2"])
def test_without_a_package_the_rest_is_still_looked_at(missing):
    """Of another Python, or damaged: it is there, and cannot be imported."""
    code = f"import sys; sys.modules[{missing!r}] = None; from edge.doctor import main; main(['--no-link'])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    *others, last = done.stdout.splitlines()
    assert done.returncode == 1 and not done.stderr, done.stderr
    assert last.startswith("the rest") and missing in last and "install the robot again" in last
    assert sum(line.startswith("package") for line in others) == len(doctor.PACKAGES) + 1


@pytest.mark.parametrize(("cosine", "good"), [(0.995, True), (0.986, True), (0.98, False), (float("nan"), False)])
def test_vectors_that_are_not_what_they_should_be_are_bad(cosine, good):
    assert bool(doctor._parity("image tower", cosine, 0.99).remedy) != good


def store_of(path, digest="abc"):
    with Vlpg.open(path, "tower", digest, 4):
        pass
    return path


def test_a_whole_store_of_the_model(tmp_path):
    (finding,) = doctor.store(store_of(tmp_path / "home.vlpg"), "abc")
    assert not finding.remedy and "0 nodes of tower" in finding.found


@pytest.mark.parametrize("name", ["a#b.vlpg", "a?b.vlpg", "a%20b.vlpg"])
def test_a_store_of_any_name_is_read(tmp_path, name):
    (finding,) = doctor.store(store_of(tmp_path / name), "abc")
    assert not finding.remedy and not (tmp_path / "a").exists()  # nothing is made of a part of the name


def test_a_store_of_somebody_else_is_not_called_damaged(tmp_path, monkeypatch):
    path = store_of(tmp_path / "home.vlpg")
    monkeypatch.setattr(doctor.os, "access", lambda *_: False)
    (finding,) = doctor.store(path, "abc")
    assert "sudo" in finding.remedy and "not yours to read" in finding.found


@pytest.mark.parametrize("how", ["other", "damaged", "absent", "not a store"])
def test_a_store_that_cannot_be_used(tmp_path, how):
    path = store_of(tmp_path / "home.vlpg")
    if how == "damaged":
        db = sqlite3.connect(path)
        db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        db.close()
        content = bytearray(path.read_bytes())
        content[100:2000] = bytes(1900)
        path.write_bytes(content)
    elif how == "absent":
        path.unlink()
    elif how == "not a store":
        path.write_text("a diary")
    before = path.read_bytes() if path.exists() else None
    (finding,) = doctor.store(path, "another" if how == "other" else "abc")
    assert finding.remedy and (how != "other" or "vlpg reindex" in finding.remedy)
    assert (path.read_bytes() if path.exists() else None) == before


def test_a_store_of_a_newer_version_is_not_called_fine(tmp_path):
    path = store_of(tmp_path / "home.vlpg")
    with sqlite3.connect(path) as db:
        db.execute("UPDATE meta SET value = '99' WHERE key = 'schema'")
    db.close()
    (finding,) = doctor.store(path, "abc")
    assert "schema is 99" in finding.remedy and "older copy" in finding.remedy


def test_a_store_that_is_whole_but_in_use_is_not_to_be_thrown_away(tmp_path):
    path = store_of(tmp_path / "home.vlpg")
    db = sqlite3.connect(path)
    db.execute("PRAGMA locking_mode = EXCLUSIVE")
    db.execute("UPDATE meta SET value = value")
    (finding,) = doctor.store(path, "abc")
    db.close()
    assert "check that no other program uses it" in finding.remedy and "map anew" not in finding.remedy


def test_who_is_alive_on_the_link_and_who_is_not(endpoint, monkeypatch):
    monkeypatch.setattr(doctor, "PATIENCE", 0.5)
    (nobody,) = doctor.link(LinkConfig((endpoint,), mode="client", multicast_scouting=False), "r", False)
    assert "nobody answers" in nobody.remedy
    with open_session(LinkConfig(listen=(endpoint,), multicast_scouting=False)) as session:
        odometry, stop = publisher(session, "r/odom"), threading.Event()

        def drive():
            while not stop.wait(0.02):
                odometry.put(messages.Odometry())

        base = threading.Thread(target=drive)
        base.start()
        found = list(doctor.link(LinkConfig((endpoint,), mode="client", multicast_scouting=False), "r", True))
        stop.set()
        base.join(5)
        assert [(f.subject, f.found) for f in found] == [("base", "odometry on r/odom"), ("host", "not heard")]
        assert not found[0].remedy and "start vlpg host" in found[1].remedy
        silent, _ = doctor.link(LinkConfig((endpoint,), mode="client", multicast_scouting=False), "r", False)
        assert "no odometry" in silent.found and "start the base" in silent.remedy


def test_the_digest_is_the_models():
    assert doctor._digest(None) == Manifest.load(resolve()).digest and doctor._digest("none") is None
