"""The archive, and its own script at work below a folder."""

import json
import os
import subprocess
import tarfile

import pytest

from models.manifest import ModelError, sha256
from tests.tools.deploy.conftest import make_wheel
from tools.deploy import bundle, command, wheels
from tools.deploy.bundle import BundleConfig, make
from tools.deploy.target import Target


def unpack(path, folder):
    with tarfile.open(path) as archive:
        archive.extractall(folder, filter="data")
    (top,) = folder.iterdir()
    return top


def names(path):
    with tarfile.open(path) as archive:
        return {name.partition("/")[2] for name in archive.getnames()}


def install(top, root, *arguments):
    command = ["sh", str(top / "install.sh"), "--root", str(root), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


def test_the_same_inputs_give_the_same_bytes(config, cache, tmp_path):
    first = make(config, tmp_path / "one", cache)
    for wheel in cache.glob("*.whl"):
        os.utime(wheel, (0, 0))
    assert sha256(first) == sha256(make(config, tmp_path / "two", cache))
    assert not list(tmp_path.glob("*/*.part"))


def test_it_has_the_robot_and_nothing_else(config, cache, tmp_path):
    found = names(make(config, tmp_path, cache))
    assert {"install.sh", "vlpg-robot.service", "robot.env", "app/edge/node.py", "app/models/manifest.py"} <= found
    assert {f"app/models/lite0-minilm/{file.name}" for file in config.model.files} <= found
    assert not any(name.startswith(("app/tools", "app/host", "app/firmware_sim", "app/tests")) for name in found)


def test_a_host_takes_the_text_tower_off_it(config, cache, tmp_path, model):
    found = names(make(BundleConfig(Target(), model, offload=True), tmp_path, cache))
    assert not any("tokenizer" in name.rpartition("/")[2] or "text.onnx" in name for name in found)
    top = unpack(tmp_path / "vlpg-edge-0.1.0-aarch64-cp311-offload.tar.gz", tmp_path / "unpacked")
    assert "--offload host" in (top / "release.env").read_text()
    assert "MemoryMax=160M" in (top / "vlpg-robot.service").read_text()


def test_no_placeholder_is_left(config, cache, tmp_path):
    top = unpack(make(config, tmp_path, cache), tmp_path / "unpacked")
    for name in ("install.sh", "vlpg-robot.service", "robot.env", "release.env"):
        assert "@" not in (top / name).read_text().replace("@system-service", "").replace("$@", "")


def test_it_installs_twice_as_once_then_updates_and_goes_back(config, cache, tmp_path, monkeypatch):
    old = unpack(make(config, tmp_path / "old", cache), tmp_path / "old-unpacked")
    monkeypatch.setattr(bundle, "version", lambda: "0.2.0")
    new = unpack(make(config, tmp_path / "new", cache), tmp_path / "new-unpacked")
    root = tmp_path / "root"
    base = root / "opt" / "vlpg"
    for _ in range(2):
        done = install(old, root)
        assert done.returncode == 0, done.stderr
    assert [path.name for path in (base / "releases").iterdir()] == [(old / "release").read_text().strip()]
    assert (base / "current" / "site" / "speed" / "__init__.py").read_text() == "answer = 42\n"
    (root / "etc" / "vlpg" / "robot.env").write_text("VLPG_OPTIONS=mine\n")

    assert install(new, root).returncode == 0
    about = json.loads((base / "current" / "about.json").read_text())
    assert about["version"] == "0.2.0" and about["digest"] == config.model.digest
    assert (root / "etc" / "vlpg" / "robot.env").read_text() == "VLPG_OPTIONS=mine\n"
    wanted = root / "etc" / "systemd" / "system" / "multi-user.target.wants" / "vlpg-robot.service"
    assert wanted.is_file() and (root / "etc" / "sysusers.d" / "vlpg.conf").read_text().startswith("u vlpg ")
    assert len(list((base / "releases").iterdir())) == 2

    assert install(new, root, "--rollback").returncode == 0
    assert json.loads((base / "current" / "about.json").read_text())["version"] == "0.1.0"
    assert install(new, root, "--rollback").returncode == 0
    assert json.loads((base / "current" / "about.json").read_text())["version"] == "0.2.0"


def test_what_a_release_was_made_for_goes_and_comes_with_it(config, cache, tmp_path, model):
    root = tmp_path / "root"
    for number, offload in enumerate((False, True)):
        made = make(BundleConfig(Target(), model, offload), tmp_path / f"a{number}", cache)
        top = unpack(made, tmp_path / f"b{number}")
        assert install(top, root).returncode == 0
    options, unit = (root / name for name in ("opt/vlpg/current/release.env", "etc/systemd/system/vlpg-robot.service"))
    assert "--offload host" in options.read_text() and "MemoryMax=160M" in unit.read_text()
    assert install(top, root, "--rollback").returncode == 0
    assert "--offload auto" in options.read_text() and "MemoryMax=200M" in unit.read_text()


def test_the_commands_of_a_release_are_its_own(config, cache, tmp_path):
    roots = tmp_path / "root", tmp_path / "root"
    pythons = [Target("aarch64", version) for version in ("3.11", "3.13")]
    for number, (target, root) in enumerate(zip(pythons, roots)):
        if number:
            wheels.write_lock(target, wheels.read_lock(Target()))
        top = unpack(make(BundleConfig(target, config.model), tmp_path / f"a{number}", cache), tmp_path / f"b{number}")
        assert install(top, root).returncode == 0
        command = root / "opt" / "vlpg" / "bin" / "vlpg-robot"
        assert f"python{target.python}" in command.read_text()
    assert install(top, root, "--rollback").returncode == 0 and "python3.11" in command.read_text()


def test_a_version_that_did_not_start_is_none_to_go_back_to(config, cache, tmp_path, monkeypatch):
    root, tops = tmp_path / "root", []
    for number in range(3):
        monkeypatch.setattr(bundle, "version", lambda number=number: f"0.{number}.0")
        tops.append(unpack(make(config, tmp_path / f"a{number}", cache), tmp_path / f"b{number}"))
    base = root / "opt" / "vlpg"
    for top in tops:
        assert install(top, root).returncode == 0
        if top == tops[1]:
            (base / "current" / "failed").touch()  # as when the service does not come up
    assert json.loads((base / "previous" / "about.json").read_text())["version"] == "0.0.0"


def test_a_third_version_replaces_the_first(config, cache, tmp_path, monkeypatch):
    root = tmp_path / "root"
    for number in range(3):
        monkeypatch.setattr(bundle, "version", lambda number=number: f"0.{number}.0")
        top = unpack(make(config, tmp_path / f"a{number}", cache), tmp_path / f"b{number}")
        assert install(top, root).returncode == 0
    assert len(list((root / "opt" / "vlpg" / "releases").iterdir())) == 2


def test_an_install_that_broke_off_is_done_again(config, cache, tmp_path):
    top, root = unpack(make(config, tmp_path / "a", cache), tmp_path / "b"), tmp_path / "root"
    assert install(top, root).returncode == 0
    current = root / "opt" / "vlpg" / "current"
    (current / "complete").unlink()
    (current / "site" / "speed" / "__init__.py").unlink()
    assert install(top, root).returncode == 0 and (current / "site" / "speed" / "__init__.py").is_file()


@pytest.mark.parametrize("damage", ["gone", "empty"])
def test_what_was_damaged_on_the_board_is_installed_again(config, cache, tmp_path, damage):
    top, root = unpack(make(config, tmp_path / "a", cache), tmp_path / "b"), tmp_path / "root"
    assert install(top, root).returncode == 0
    file = root / "opt" / "vlpg" / "current" / "site" / "speed" / "__init__.py"
    file.unlink() if damage == "gone" else file.write_text("")
    assert install(top, root).returncode == 0 and file.read_text() == "answer = 42\n"


def test_a_damaged_bundle_changes_nothing(config, cache, tmp_path):
    top = unpack(make(config, tmp_path / "a", cache), tmp_path / "b")
    (top / "wheels" / "speed-1.0-py3-none-any.whl").write_bytes(b"half a whe")
    done = install(top, tmp_path / "root")
    assert done.returncode == 1 and "copy it again" in done.stderr and not (tmp_path / "root").exists()


def test_the_services_user_can_read_what_a_careful_root_installs(config, cache, tmp_path):
    top = unpack(make(config, tmp_path / "a", cache), tmp_path / "b")
    for file in top.rglob("*"):
        file.chmod(0o700 if file.is_dir() else 0o600)  # as unpacked by one with this umask
    root = tmp_path / "root"
    command = f"umask 077; sh {top}/install.sh --root {root}"
    assert subprocess.run(command, shell=True, capture_output=True, timeout=120).returncode == 0
    base = root / "opt" / "vlpg"
    for path in (base, *base.rglob("*")):
        wanted = 0o555 if path.is_dir() else 0o444
        assert path.stat().st_mode & wanted == wanted, path


def test_what_cannot_be_done_is_one_sentence(config, cache, tmp_path):
    top = unpack(make(config, tmp_path / "a", cache), tmp_path / "b")
    done = install(top, tmp_path / "root", "--rollback")
    assert done.returncode == 1 and done.stderr == "install.sh: there is no version before this one\n"
    done = install(top, tmp_path / "root", "--what")
    assert done.returncode == 2 and "--rollback" in done.stderr and "set -eu" not in done.stderr


def test_a_model_that_is_not_whole_is_not_bundled(cache, tmp_path, model):
    from dataclasses import replace

    with pytest.raises(ModelError, match="missing"):
        make(BundleConfig(Target(), replace(model, folder=tmp_path)), tmp_path / "out", cache)
    assert not (tmp_path / "out").exists()


def test_the_command(cache, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "cache_file", lambda name: cache)
    with pytest.raises(SystemExit) as ended:
        command.main(["bundle", "--out", str(tmp_path)])
    assert ended.value.code == 0
    printed = capsys.readouterr().out
    assert "aarch64-cp311.tar.gz" in printed and "sha256" in printed
    monkeypatch.setattr(wheels, "requirements", lambda: ["newcomer"])
    with pytest.raises(SystemExit) as ended:
        command.main(["bundle", "--out", str(tmp_path)])
    assert ended.value.code == 2 and "lacks newcomer" in capsys.readouterr().err


def test_a_changed_wheel_makes_another_release(config, cache, tmp_path):
    first = unpack(make(config, tmp_path / "a", cache), tmp_path / "b")
    wheel = make_wheel(cache, "speed", "answer = 43\n")
    _, tokenizers = wheels.read_lock(Target())
    wheels.write_lock(Target(), [wheels.Locked("speed", "1.0", sha256(wheel)), tokenizers])
    second = unpack(make(config, tmp_path / "c", cache), tmp_path / "d")
    assert (first / "release").read_text() != (second / "release").read_text()
