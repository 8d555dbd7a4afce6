"""Locks and wheels; nothing is fetched."""

import pytest
from packaging.requirements import Requirement

from tests.tools.deploy.conftest import make_wheel
from tools.deploy import wheels
from tools.deploy.target import MACHINES, PYTHONS, DeployError, Target, requirements, version


def test_what_the_robot_needs_is_what_setup_cfg_says():
    names = [requirement.name for requirement in requirements()]
    assert {"numpy", "onnxruntime", "opencv-python-headless", "eclipse-zenoh"} <= set(names)
    assert version().count(".") == 2


@pytest.mark.parametrize("python", PYTHONS)
def test_the_committed_locks_have_all_of_it_with_hashes(python):
    locked = wheels.read_lock(Target("aarch64", python))
    assert {requirement.name for requirement in requirements()} <= {one.name for one in locked}
    assert not {"scipy", "filterpy", "huggingface-hub"} & {one.name for one in locked}


def test_pip_is_told_of_the_target_and_not_of_here():
    options = Target("aarch64", "3.13").pip_options()
    assert "--only-binary=:all:" in options and "manylinux_2_28_aarch64" in options and "cp313" in options
    assert not any("x86_64" in option or "311" in option for option in options)
    assert {Target(machine, python).name for machine in MACHINES for python in PYTHONS} >= {"aarch64-cp311"}


def test_wheels_at_hand_are_taken_by_their_hash(cache):
    found = wheels.fetch(Target(), wheels.read_lock(Target()), cache)
    assert [wheel.name.split("-")[0] for wheel in found] == ["speed", "tokenizers"]


def test_a_wheel_that_changed_is_asked_for_again(cache, monkeypatch):
    asked = []

    def download(target, folder, what):
        asked.append(what)
        make_wheel(folder, "speed")

    monkeypatch.setattr(wheels, "_download", download)
    make_wheel(cache, "speed", "answer = 41\n")
    found = wheels.fetch(Target(), wheels.read_lock(Target()), cache)
    assert len(asked) == 1 and "--require-hashes" in asked[0] and len(found) == 2


def test_a_lock_that_lacks_something_or_is_not_there_is_told(cache, monkeypatch):
    with pytest.raises(DeployError, match="nothing is locked for x86_64-cp313; run: vlpg deploy lock --target x86_64"):
        wheels.read_lock(Target("x86_64", "3.13"))
    for wanted in ("newcomer>=2", "tokenizers>=1.1"):
        monkeypatch.setattr(wheels, "requirements", lambda wanted=wanted: [Requirement("speed"), Requirement(wanted)])
        with pytest.raises(DeployError, match=f"lacks {wanted}; run: vlpg deploy lock"):
            wheels.read_lock(Target())
    Target().lock.write_text("speed==1.0\n")
    with pytest.raises(DeployError, match="damaged"):
        wheels.read_lock(Target())


def test_a_wheel_that_unpacking_would_not_install_is_refused(cache):
    wheel = make_wheel(cache, "odd", extra={"odd-1.0.data/purelib/odd.py": ""})
    locked = [wheels.Locked("odd", "1.0", wheels.sha256(wheel))]
    with pytest.raises(DeployError, match="odd-1.0.*purelib"):
        wheels.fetch(Target(), locked, cache)


def test_what_pip_says_is_passed_on(tmp_path, monkeypatch):
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    with pytest.raises(DeployError, match="cannot be had: ERROR: No matching distribution"):
        wheels.resolve(Target())
