"""The archive, and its own script at work below a folder."""

import json
import os
import shutil
import subprocess
import sys
import tarfile
from dataclasses import replace

import pytest
from packaging.requirements import Requirement

from models.manifest import ModelError, sha256
from tests.tools.deploy.conftest import make_wheel
from tools.deploy import bundle, command, wheels
from tools.deploy.bundle import BundleConfig, make
from tools.deploy.target import DeployError, Target


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


def releases(count, config, cache, folder, monkeypatch):
    """Unpacked bundles of the versions 0.0.0, 0.1.0 and so on."""
    for number in range(count):
        monkeypatch.setattr(bundle, "version", lambda number=number: f"0.{number}.0")
        yield unpack(make(config, folder / f"a{number}", cache), folder / f"b{number}")


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
    assert "MemoryMax=160000000\n" in (top / "vlpg-robot.service").read_text()


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
    assert "--offload host" in options.read_text() and "MemoryMax=160000000\n" in unit.read_text()
    assert install(top, root, "--rollback").returncode == 0
    assert "--offload auto" in options.read_text() and "MemoryMax=200000000\n" in unit.read_text()


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
    root, tops = tmp_path / "root", list(releases(3, config, cache, tmp_path, monkeypatch))
    base = root / "opt" / "vlpg"

    def version(which):
        return json.loads((base / which / "about.json").read_text())["version"]

    for top in tops:
        assert install(top, root).returncode == 0
        if top == tops[1]:
            (base / "current" / "failed").touch()  # as when the service does not come up
    assert version("previous") == "0.0.0"
    (base / "current" / "failed").touch()
    assert install(tops[0], root, "--rollback").returncode == 0 and version("current") == "0.0.0"
    assert "no version before" in install(tops[0], root, "--rollback").stderr
    assert install(tops[1], root).returncode == 0 and version("previous") == "0.0.0"
    (base / "current" / "failed").touch()
    assert install(tops[0], root).returncode == 0 and version("current") == "0.0.0"
    assert "no version before" in install(tops[0], root, "--rollback").stderr


def test_a_third_version_replaces_the_first(config, cache, tmp_path, monkeypatch):
    root = tmp_path / "root"
    for top in releases(3, config, cache, tmp_path, monkeypatch):
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


def test_a_repair_that_cannot_be_written_costs_nothing_that_is_there(config, cache, tmp_path):
    top, root = unpack(make(config, tmp_path / "a", cache), tmp_path / "b"), tmp_path / "root"
    assert install(top, root).returncode == 0
    current = root / "opt" / "vlpg" / "current"
    (current / "site" / "speed" / "__init__.py").unlink()
    before = {path.relative_to(current) for path in current.rglob("*")}
    environment = only(tmp_path / "full", "3.11")
    (tmp_path / "full" / "sync").unlink()
    (tmp_path / "full" / "sync").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "full" / "sync").chmod(0o755)
    command = ["sh", str(top / "install.sh"), "--root", str(root)]
    assert subprocess.run(command, env=environment, capture_output=True, timeout=120).returncode == 1
    assert {path.relative_to(current) for path in current.rglob("*")} == before
    assert len(list((root / "opt" / "vlpg" / "releases").iterdir())) == 1


def test_what_is_installed_goes_back_by_itself(config, cache, tmp_path, monkeypatch):
    root = tmp_path / "root"
    for top in releases(2, config, cache, tmp_path, monkeypatch):
        assert install(top, root).returncode == 0
        shutil.rmtree(top)
    current = root / "opt" / "vlpg" / "current"
    again = install(current, root)
    assert again.returncode == 1 and "only --rollback" in again.stderr and again.stderr.count("\n") == 1
    assert install(current, root, "--rollback").returncode == 0
    assert json.loads((current / "about.json").read_text())["version"] == "0.0.0"


@pytest.mark.parametrize("file", ["wheels/speed-1.0-py3-none-any.whl", "app/edge/__init__.py", "files.sha256"])
def test_a_damaged_bundle_changes_nothing(config, cache, tmp_path, file):
    top = unpack(make(config, tmp_path / "a", cache), tmp_path / "b")
    (top / file).write_bytes(b"half a fil")
    done = install(top, tmp_path / "root")
    assert done.returncode == 1 and "copy it again" in done.stderr and not (tmp_path / "root").exists()


def test_what_lies_in_the_folder_it_is_called_from_is_not_imported_by_root(config, cache, tmp_path):
    top = unpack(make(config, tmp_path / "a", cache), tmp_path / "b")
    for name in ("struct", "zipfile", "compileall"):
        (tmp_path / f"{name}.py").write_text("open('imported', 'w')\n")
    command = ["sh", str(top / "install.sh"), "--root", str(tmp_path / "root")]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=120).returncode == 0
    assert not (tmp_path / "imported").exists()
    assert (tmp_path / "root" / "opt" / "vlpg" / "current" / "site" / "speed" / "__init__.py").is_file()


TOOLS = "sh sha256sum cut cat sed cp mv rm ln find sync touch mkdir chmod readlink dirname"


def only(folder, version):
    """An environment in whose PATH this Python is the only one, and says to a shell that it is of that version."""
    folder.mkdir()
    (folder / "python3").write_text(f"""#!/bin/sh
case "$*" in
*struct*) echo {version}, 64 bit; exit ;;
*version_info*) exit {int(version != "3.11")} ;;
esac
exec {sys.executable} "$@"
""")
    (folder / "python3").chmod(0o755)
    for tool in TOOLS.split():
        (folder / tool).symlink_to(shutil.which(tool))
    return {"PATH": str(folder)}


def test_a_card_is_compiled_for_where_there_is_its_python(config, cache, tmp_path):
    top, root = unpack(make(config, tmp_path / "a", cache), tmp_path / "b"), tmp_path / "root"
    site = root / "opt" / "vlpg" / "current" / "site" / "speed"
    command = ["sh", str(top / "install.sh"), "--root", str(root)]
    for version, compiled in (("3.13", False), ("3.11", True)):
        environment = only(tmp_path / version, version)
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0 and ("not compiled" in done.stderr) != compiled, done.stderr
        assert (site / "__pycache__").is_dir() == compiled


def test_with_another_python_than_it_was_made_for_it_does_not_run(config, cache, tmp_path):
    top, root = unpack(make(config, tmp_path / "a", cache), tmp_path / "b"), tmp_path / "root"
    assert install(top, root).returncode == 0
    command = ["sh", str(root / "opt" / "vlpg" / "bin" / "vlpg-robot"), "--help"]
    done = subprocess.run(command, env=only(tmp_path / "3.13", "3.13"), capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "there is no Python 3.11 any more" in done.stderr and "Traceback" not in done.stderr


def test_a_full_disk_leaves_no_half_of_an_archive(config, cache, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(bundle, "pack", full)
    with pytest.raises(OSError, match="No space"):
        make(config, tmp_path / "out", cache)
    assert not list((tmp_path / "out").iterdir())


def test_a_model_whose_name_a_service_would_take_for_two_is_refused(config, cache, tmp_path, model):
    with pytest.raises(DeployError, match="my model"):
        make(BundleConfig(Target(), replace(model, folder=tmp_path / "my model")), tmp_path / "out", cache)


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
    monkeypatch.setattr(wheels, "requirements", lambda: [Requirement("newcomer")])
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
