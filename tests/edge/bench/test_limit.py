"""A process that wants more than it may have."""

import subprocess
import sys
from pathlib import Path

import pytest

from edge.bench import limit
from edge.bench.limit import MemoryLimit

WANT = "block = bytearray({size}); print(len(block))"


def run(size, limited):
    code = WANT.format(size=size)
    return subprocess.run([sys.executable, "-c", code], preexec_fn=limited.enter, capture_output=True, text=True)


@pytest.fixture
def without_cgroups(monkeypatch, tmp_path):
    monkeypatch.setattr(limit, "CGROUPS", tmp_path)


def test_enough_is_enough(without_cgroups):
    with MemoryLimit(100) as limited:
        assert limited.kind.startswith("RLIMIT_DATA")
        assert run(10_000_000, limited).stdout == "10000000\n"


def test_more_is_refused(without_cgroups):
    with MemoryLimit(100) as limited:
        assert "MemoryError" in run(200_000_000, limited).stderr


def test_a_group_that_takes_no_limit_is_not_said_to_limit(monkeypatch, tmp_path):
    monkeypatch.setattr(limit, "CGROUPS", tmp_path)
    (tmp_path / "cgroup.subtree_control").write_text("memory\n")
    write = Path.write_text

    def refuse(file, text):
        if file.name == "memory.max":
            raise PermissionError(13, "Permission denied")
        return write(file, text)

    monkeypatch.setattr(Path, "write_text", refuse)
    with MemoryLimit(100) as limited:
        assert limited.kind.startswith("RLIMIT_DATA")
    assert [path.name for path in tmp_path.iterdir()] == ["cgroup.subtree_control"]


def test_a_control_group_gets_the_limit_and_goes_again(monkeypatch, tmp_path):
    """The kernel's files, as they are where the memory controller may be used."""
    monkeypatch.setattr(limit, "CGROUPS", tmp_path)
    (tmp_path / "cgroup.subtree_control").write_text("cpu memory pids\n")
    with MemoryLimit(100) as limited:
        (group,) = (path for path in tmp_path.iterdir() if path.is_dir())
        assert limited.kind == "control group" and (group / "memory.max").read_text() == "100000000"
        assert limited.peak is None
        (group / "memory.peak").write_text("90000000\n")
        assert limited.peak == 90.0
        limited.enter()
        assert (group / "cgroup.procs").read_text().isdigit()
        for file in group.iterdir():
            file.unlink()  # the kernel's go by themselves
    assert not group.exists()
