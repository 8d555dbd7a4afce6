"""A real sshd on the loopback interface, whose board is this machine below a folder."""

import getpass
import os
import shutil
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import edge
from edge.bench.recording import write
from edge.bench.report import Report
from edge.observation import Observation
from tools.deploy import bundle, command, remote
from tools.deploy.bundle import BundleConfig, contents
from tools.deploy.remote import Board, Facts
from tools.deploy.target import DeployError, Target

SSHD = shutil.which("sshd", path=os.environ["PATH"] + ":/usr/sbin")
BOARD = Facts("aarch64", 64, (2, 36), False, True, ("3.11",), 5000.0, 400.0, frozenset({"asimd", "asimddp"}), 0.5)


@pytest.fixture
def ssh(tmp_path, monkeypatch):
    """The command that reaches it. The bundle is kept in a folder of the test, not in the home of who runs it."""
    if SSHD is None or shutil.which("ssh") is None:
        pytest.skip("needs openssh-server and openssh-client")
    for key in ("host", "client"):
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", tmp_path / key], check=True)
    shutil.copy(tmp_path / "client.pub", tmp_path / "authorized")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    (tmp_path / "sshd_config").write_text(
        f"ListenAddress 127.0.0.1\nPort {port}\nHostKey {tmp_path}/host\nAuthorizedKeysFile {tmp_path}/authorized\n"
        f"StrictModes no\nUsePAM no\nPasswordAuthentication no\nPidFile none\nPermitRootLogin yes\n"
        f"SetEnv PATH={os.path.dirname(sys.executable)}:/usr/bin:/bin\n"
    )
    os.makedirs("/run/sshd", exist_ok=True) if os.getuid() == 0 else None
    with subprocess.Popen([SSHD, "-D", "-e", "-f", tmp_path / "sshd_config"], stderr=subprocess.PIPE) as server:
        for _ in range(100):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    break
            assert server.poll() is None, server.stderr.read()
            time.sleep(0.05)
        monkeypatch.setattr(remote, "FOLDER", str(tmp_path / "sent"))
        monkeypatch.setattr(remote, "MEASURED", str(tmp_path / "measured"))
        options = f"-p {port} -i {tmp_path}/client -o StrictHostKeyChecking=no -o UserKnownHostsFile={tmp_path}/known"
        yield f"ssh -q -o BatchMode=yes {options}"
        server.terminate()


@pytest.fixture
def board(ssh, tmp_path):
    return Board(f"{getpass.getuser()}@127.0.0.1", ssh, str(tmp_path / "root"))


def test_what_the_board_is(board):
    facts = board.probe()
    assert facts.machine == os.uname().machine and f"{sys.version_info[0]}.{sys.version_info[1]}" in facts.pythons
    assert facts.disk > 0 and facts.memory > 0 and abs(facts.clock) < 5 and facts.features
    assert facts.bits == 64 and facts.libc >= (2, 28) and facts.target(offload=False).machine == facts.machine


@pytest.mark.parametrize("link", [False, True])
def test_what_is_in_the_way_on_the_board_costs_none_of_its_files(link, tmp_path):
    """A file, or a link to nowhere, where the bundle's folder belongs. The ssh here runs what it is to run there."""
    (tmp_path / "ssh").write_text('#!/bin/sh\ncd "$(dirname "$0")/home" && HOME=$PWD exec sh -c "$2"\n')
    home = tmp_path / "home"
    (home / "photos").mkdir(parents=True)
    (home / "thesis.txt").write_text("mine")
    (home / "photos" / "a.jpg").write_text("mine")
    if link:
        (home / remote.FOLDER).symlink_to("nowhere")
    else:
        (home / remote.FOLDER).write_text("a file of this name")
    with pytest.raises(DeployError, match="board"):
        Board("me@board", f"sh {tmp_path}/ssh").send({"a.txt": b"one"})
    assert (home / "thesis.txt").exists() and (home / "photos" / "a.jpg").exists()


def test_only_what_changed_is_sent_and_what_is_gone_is_removed(board, tmp_path):
    content = {"a/b.txt": b"one", "c.sh": b"#!/bin/sh\n", "d 'e": b"two"}
    assert board.send(content) == (3, 16)
    assert board.send(content) == (0, 0)
    assert board.send({"a/b.txt": b"three", "c.sh": b"#!/bin/sh\n"}) == (1, 5)
    there = {str(p.relative_to(tmp_path / "sent")) for p in (tmp_path / "sent").rglob("*") if p.is_file()}
    assert there == {"a/b.txt", "c.sh"} and (tmp_path / "sent" / "a" / "b.txt").read_bytes() == b"three"
    assert os.access(tmp_path / "sent" / "c.sh", os.X_OK)


def test_it_is_installed_updated_and_taken_back(board, cache, model, monkeypatch, tmp_path):
    assert board.release() == ""
    installed = tmp_path / "root" / "opt" / "vlpg" / "bin"
    config = BundleConfig(Target(), model, offload=True)
    releases = []
    for number in (1, 2):
        monkeypatch.setattr(bundle, "version", lambda number=number: f"{number}.0")
        board.send(contents(config, cache))
        assert board.install().startswith("installed ")
        releases.append(board.release())
    assert releases[0] != releases[1]
    assert "back at" in board.rollback() and board.release() == releases[0]
    assert "-m edge.doctor --model lite0-minilm --offload host" in (installed / "vlpg-doctor").read_text()
    table, well = board.doctor()
    assert not well and "No module named 'zenoh'" in table and "Traceback" not in table  # its wheels are not real ones


def test_the_commands(ssh, cache, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "_cache", lambda target: cache)
    monkeypatch.setattr(Board, "probe", lambda self: BOARD)
    there = [f"{getpass.getuser()}@127.0.0.1", "--ssh", ssh, "--root", str(tmp_path / "root")]

    def run(*arguments):
        with pytest.raises(SystemExit) as ended:
            command.main([*arguments, *there])
        return ended.value.code, "".join(capsys.readouterr())

    assert run("status") == (1, "installed: nothing\n")
    code, said = run("push")
    assert code == 1 and "asimddp" in said and "installed " in said and "zenoh" in said
    assert run("status")[0] == 0
    code, said = run("rollback")
    assert code == 2 and "there is no version before this one" in said


@pytest.fixture
def measuring(ssh, tmp_path, monkeypatch, capfd):
    """``vlpg deploy bench`` with a recording of one moment; the board has this source tree's benchmarks."""
    installed = tmp_path / "root" / "opt" / "vlpg" / "bin" / "vlpg-bench"
    installed.parent.mkdir(parents=True)
    code = Path(edge.__file__).parents[1]
    installed.write_text(f'#!/bin/sh\ncd {code} && exec {sys.executable} -m edge.bench "$@"\n')
    installed.chmod(0o755)
    write(tmp_path / "home.rec", [Observation(0.0, np.zeros(3), np.zeros(2))])
    options = ["--ssh", ssh, "--root", str(tmp_path / "root"), "--recording", str(tmp_path / "home.rec")]

    def run(*arguments):
        with pytest.raises(SystemExit) as ended:
            command.main(["bench", f"{getpass.getuser()}@127.0.0.1", *options, *arguments])
        return ended.value.code, "".join(capfd.readouterr())

    return run


def test_it_is_measured_there_and_the_figures_come_back(measuring, tmp_path):
    code, said = measuring("store", "--runs", "1", "--budget", "pi-zero-2w", "--json", str(tmp_path / "here.json"))
    assert code == 0 and "within the budget pi-zero-2w" in said
    assert Report.load(tmp_path / "here.json").runs == 1
    sent = tmp_path / "measured" / "home.rec"
    assert sent.read_bytes() == (tmp_path / "home.rec").read_bytes()
    before = sent.stat().st_mtime_ns
    assert measuring("store", "--runs", "1")[0] == 0 and sent.stat().st_mtime_ns == before


def test_what_cannot_be_measured_there_leaves_no_file(measuring, tmp_path):
    code, said = measuring("encoder", "--model", "nope", "--json", str(tmp_path / "here.json"))
    assert code == 2 and "no model named nope" in said and not (tmp_path / "here.json").exists()
    (tmp_path / "home.rec").write_bytes(b"nothing")
    code, said = measuring("store")
    assert code == 2 and "no whole recording" in said


def test_what_is_no_linux_is_told(tmp_path):
    (tmp_path / "ssh").write_text("#!/bin/sh\necho machine x86_64\n")
    with pytest.raises(DeployError, match="board does not tell what it is"):
        Board("me@board", f"sh {tmp_path}/ssh").probe()


@pytest.mark.parametrize("installed", [True, False])
def test_a_robot_that_does_not_start_is_looked_at_by_the_doctor(monkeypatch, cache, model, capsys, installed):
    """Its script and its journal are a real board's; here they are what they would say."""
    release = contents(BundleConfig(Target(), model), cache)["release"].decode().strip() if installed else "older"

    def fails(self):
        raise DeployError("the robot does not start")

    told = {
        "probe": lambda self: BOARD,
        "send": lambda self, content: (0, 0),
        "install": fails,
        "release": lambda self: release,
        "doctor": lambda self: ("the table\n", False),
        "logs": lambda self: print("why"),
    }
    for name, says in told.items():
        monkeypatch.setattr(Board, name, says)
    monkeypatch.setattr(command, "_cache", lambda target: cache)
    with pytest.raises(SystemExit) as ended:
        command.main(["push", "me@board"])
    said = capsys.readouterr()
    assert ended.value.code == 2 and "does not start" in said.err
    assert said.out.endswith("the table\nwhy\n") == installed


def test_who_is_not_there_or_does_not_let_us_in(ssh, tmp_path):
    with pytest.raises(DeployError, match="127.0.0.1"):
        Board("somebody@127.0.0.1", ssh.replace("/client ", "/host ")).probe()
    with pytest.raises(DeployError, match="no destination"):
        Board("-oProxyCommand=touch")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"machine": "armv7l"}, "the board is armv7l"),
        ({"bits": 32}, "of 32 bit"),
        ({"libc": (2, 24)}, "glibc 2.24"),
        ({"pythons": ()}, "no Python 3.11 or 3.13"),
        ({"root": False}, "no sudo, or it asks for a password"),
        ({"disk": 100.0}, "100 MB of disk"),
        ({"memory": 50.0}, "50 MB of memory"),
        ({"clock": -86400.0}, "-86400 s off"),
    ],
)
def test_a_board_that_will_not_do_is_told_before_anything_is_sent(change, words):
    with pytest.raises(DeployError, match=words):
        replace(BOARD, **change).target(offload=False)
    assert BOARD.target(offload=False) == Target("aarch64", "3.11")


def test_an_update_and_a_robot_without_text_tower_need_less_room():
    full, small = replace(BOARD, disk=600.0), replace(BOARD, memory=180.0)
    for board, offload in ((full, False), (small, False)):
        with pytest.raises(DeployError, match="free"):
            board.target(offload)
    assert replace(full, installed=True).target(False) == small.target(True) == BOARD.target(False)
