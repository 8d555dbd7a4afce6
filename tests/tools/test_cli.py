import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

import models
from tools import cli
from tools.demo.processes import free_port

VLPG = [sys.executable, "-m", "tools.cli"]


def vlpg(*arguments, cwd=None, **environment):
    environment = os.environ | {name: str(value) for name, value in environment.items()}
    return subprocess.run([*VLPG, *arguments], capture_output=True, text=True, cwd=cwd, timeout=60, env=environment)


def complains(done, *words, code=2):
    """One line on stderr with these words, and no traceback."""
    assert done.returncode == code, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    for word in words:
        assert word in done.stderr
    return True


@pytest.fixture
def nowhere():
    """Flags of a session in which nobody else is."""
    return "--connect", f"tcp/127.0.0.1:{free_port()}", "--no-multicast-scouting", "--mode", "client"


def test_help_names_every_command_and_is_quick():
    started = time.perf_counter()
    done = vlpg("--help")
    assert time.perf_counter() - started < 3.0  # 0.2 s on an idle machine
    assert done.returncode == 0
    for command in "demo sim robot host find tour status cancel reindex models eval bench".split():
        assert f"  {command} " in done.stdout


def test_help_imports_nothing_heavy():
    script = "import sys; import tools.cli; print([m for m in ('numpy', 'cv2', 'zenoh', 'rich') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("part", ["sim", "robot", "host", "find", "tour", "status", "cancel"])
def test_each_part_has_zenohs_flags(part):
    done = vlpg(part, "--help")
    assert done.returncode == 0 and done.stdout.startswith(f"usage: vlpg {part} "), done.stderr
    for flag in ("--connect", "-e", "--listen", "-l", "--mode", "-m", "--config", "-c", "--no-multicast-scouting"):
        assert flag in done.stdout


@pytest.mark.parametrize(
    ("arguments", "joins"),
    [
        (["--model", "b32"], True),
        (["--memory", "x"], True),
        (["--mode", "client"], False),
        (["--mode=peer"], False),
        (["-etcp/127.0.0.1:7000"], False),
        (["-l", "tcp/127.0.0.1:7000"], False),
    ],
)
def test_without_zenoh_flags_the_parts_meet(arguments, joins, monkeypatch):
    became = []
    monkeypatch.setattr(cli, "_become", lambda program, given: became.append(given))
    cli._join("edge.node", arguments, ("--connect", cli.MEETING_PLACE))
    assert (cli.MEETING_PLACE in became[0]) == joins


@pytest.mark.parametrize("part", ["find", "encoder", "graph", "life"])
def test_each_evaluation_explains_itself(part):
    done = vlpg("eval", part, "--help")
    assert done.returncode == 0 and done.stdout.startswith(f"usage: vlpg eval {part}")


def test_the_benchmark_explains_itself():
    done = vlpg("bench", "--help")
    assert done.returncode == 0 and done.stdout.startswith("usage: vlpg bench ") and "vlpg bench peers" in done.stdout


@pytest.mark.parametrize("question", [("find", "teddy bear"), ("tour",), ("status",), ("cancel",)])
def test_a_robot_that_is_not_there(question, nowhere):
    assert complains(vlpg(*question, *nowhere), "nobody answers at tcp/127.0.0.1:")


@pytest.mark.parametrize("words", ["", "  "])
def test_an_empty_question(words):
    assert complains(vlpg("find", words), "say what to find")


def test_a_picture_that_could_not_be_kept_is_not_driven_for(tmp_path):
    assert complains(vlpg("find", "plant", "--picture", str(tmp_path / "none" / "a.png")), "there is no folder")


def test_a_search_is_in_memory_or_in_the_unknown():
    done = vlpg("find", "plant", "--search", "--explore")
    assert done.returncode == 2 and "not allowed with" in done.stderr


def test_a_home_or_a_step_that_does_not_exist_is_told_at_once(tmp_path):
    assert complains(vlpg("eval", "find", "--homes", "generated:0-98,appartment"), "appartment")
    done = vlpg("eval", "overlay", "cottage", "plant", str(tmp_path / "a.png"), "--step", "0")
    assert done.returncode == 2 and "at least 1" in done.stderr
    done = vlpg("eval", "find", "--methods", "")
    assert done.returncode == 2 and "no method is named" in done.stderr


def test_an_unknown_mode(nowhere):
    done = vlpg("status", *nowhere[:2], "--mode", "emperor")
    assert done.returncode == 2 and "'peer', 'client', 'router'" in done.stderr and "emperor" in done.stderr


def test_an_unknown_home():
    for command in ("sim", "demo"):
        assert complains(vlpg(command, "--home", "atlantis"), "atlantis", "apartment, bungalow, cottage")


def test_a_house_file_with_a_thing_in_a_wall(tmp_path):
    source = Path("firmware_sim/homes/apartment.json")
    home = json.loads(source.read_text())
    thing = next(thing for thing in home["objects"] if thing["id"] == "teddy-bear-1")
    thing["position"] = home["walls"][0]["a"]
    broken = tmp_path / "broken.json"
    broken.write_text(json.dumps(home))
    assert complains(vlpg("demo", "--home", str(broken), "--out", str(tmp_path)), "broken.json", "teddy-bear-1")


def test_a_demo_without_words(tmp_path):
    assert complains(vlpg("demo", "--object", " ", "--out", str(tmp_path)), "--object was empty")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    assert complains(vlpg("demo", "--out", str(tmp_path / "file")), "file")


def test_a_busy_port():
    port = free_port()
    flags = ("--listen", f"tcp/127.0.0.1:{port}", "--no-multicast-scouting")
    with subprocess.Popen([*VLPG, "sim", *flags], stderr=subprocess.DEVNULL) as sim:
        try:
            deadline = time.monotonic() + 30
            while not _listens(port):
                assert time.monotonic() < deadline, "the simulator does not listen"
                time.sleep(0.1)
            assert complains(vlpg("sim", *flags), f"127.0.0.1:{port}", "already in use")
        finally:
            sim.send_signal(signal.SIGINT)
        assert sim.wait(10) == 0  # Ctrl-C is a clean end


def _listens(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def test_models_are_listed_and_verified():
    assert "lite0-minilm" in vlpg("models", "list").stdout
    done = vlpg("models", "verify", "--files-only")
    assert done.returncode == 0 and done.stdout.strip().endswith("files as in the manifest")


def test_a_model_is_measured_again():
    done = vlpg("models", "verify", "lite0-minilm")
    assert done.returncode == 0, done.stdout + done.stderr
    for figure in ("median cosine to float32", "peak PSS", "p50", "p95"):
        assert figure in done.stdout


def test_a_card_that_promises_too_much_is_found_out(tmp_path):
    folder = tmp_path / "model"
    shutil.copytree(Path(models.__file__).parent / "lite0-minilm", folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["measured"]["image_memory"] = 20.0
    (folder / "manifest.json").write_text(json.dumps(manifest))
    done = vlpg("models", "verify", str(folder))
    assert done.returncode == 1 and "differs: more than 15% above" in done.stdout


def test_a_damaged_model(tmp_path):
    folder = tmp_path / "model"
    shutil.copytree(Path(models.__file__).parent / "lite0-minilm", folder)
    weights = max(folder.iterdir(), key=lambda path: path.stat().st_size)
    with weights.open("r+b") as stream:
        stream.seek(1000)
        stream.write(b"damage")
    assert complains(vlpg("models", "verify", str(folder)), weights.name, "damaged")
    assert complains(vlpg("robot", "--model", str(folder), "--memory", str(tmp_path / "home.vlpg")), "damaged")


def test_an_unknown_model():
    assert complains(vlpg("models", "verify", "gpt"), "gpt", "lite0-minilm")


def test_a_model_of_the_users_own(tmp_path):
    shelf = tmp_path / "shelf"
    shutil.copytree(Path(models.__file__).parent / "lite0-minilm", shelf / "mine")
    listed = vlpg("models", "list", VLPG_MODELS=shelf).stdout
    assert "lite0-minilm" in listed and "mine" in listed
    assert vlpg("models", "verify", "mine", VLPG_MODELS=shelf).returncode == 0
    assert complains(vlpg("models", "remove", "lite0-minilm", VLPG_MODELS=shelf), "shipped")
    assert vlpg("models", "remove", "mine", VLPG_MODELS=shelf).returncode == 0
    assert list(shelf.iterdir()) == []
    assert complains(vlpg("models", "remove", "mine", VLPG_MODELS=shelf), "no model named mine")


def test_a_model_that_cannot_be_read_hides_no_other(tmp_path):
    shelf = tmp_path / "shelf"
    shutil.copytree(Path(models.__file__).parent / "lite0-minilm", shelf / "mine")
    (shelf / "mine" / "manifest.json").write_text("{")
    for command in (["list"], ["verify", "--files-only"]):
        done = vlpg("models", *command, VLPG_MODELS=shelf)
        assert done.returncode == 2 and "lite0-minilm" in done.stdout and "cannot be read" in done.stderr


def test_a_model_is_pulled_from_a_hub(tmp_path):
    place = tmp_path / "hub" / "me" / "small" / "resolve" / "main"
    shutil.copytree(Path(models.__file__).parent / "lite0-minilm", place)
    port, shelf = free_port(), tmp_path / "shelf"
    serving = [sys.executable, "-m", "http.server", str(port), "--bind", "127.0.0.1", "--directory", tmp_path / "hub"]
    where = {"HF_ENDPOINT": f"http://127.0.0.1:{port}", "HF_HUB_OFFLINE": 0, "no_proxy": "127.0.0.1"}
    where["VLPG_MODELS"] = shelf
    with subprocess.Popen(serving, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        try:
            deadline = time.monotonic() + 30
            while not _listens(port):
                assert time.monotonic() < deadline, "the hub does not listen"
                time.sleep(0.05)
            done = vlpg("models", "pull", "me/small", "--name", "mine", **where)
            assert done.returncode == 0 and done.stdout.startswith("mine: ") and " MB in " in done.stdout
            assert done.stderr == ""
            assert complains(vlpg("models", "pull", "me/nothing", **where), "no vlpg model at")
        finally:
            server.terminate()
    assert vlpg("models", "verify", "mine", **where).returncode == 0
    assert complains(vlpg("models", "pull", "me/other", **where), "cannot be reached", "HF_ENDPOINT")
    assert complains(vlpg("models", "pull", "me/other", **where | {"HF_HUB_OFFLINE": 1}), "HF_HUB_OFFLINE is set")
    assert [path.name for path in shelf.iterdir()] == ["mine"]


def test_an_import_that_cannot_be(tmp_path):
    shelf = {"VLPG_MODELS": tmp_path / "shelf"}
    assert complains(vlpg("models", "import", "./nothing", "--name", "mine", **shelf), "no folder ./nothing")
    assert complains(vlpg("models", "import", str(tmp_path), "--name", "mine", **shelf), "nothing to import")
    assert complains(vlpg("models", "import", str(tmp_path), "--name", "a/b", **shelf), "no name for a model")
    assert complains(vlpg("models", "import", str(tmp_path), "--name", "lite0-minilm", **shelf), "shipped")
    assert not (tmp_path / "shelf").exists()


def test_a_store_of_another_encoder(tmp_path):
    from edge.memory.store import Vlpg

    store = tmp_path / "home.vlpg"
    Vlpg.open(store, "someone-elses", "0" * 64, 384).close()
    flags = ("--listen", f"tcp/127.0.0.1:{free_port()}", "--no-multicast-scouting")
    assert complains(vlpg("robot", "--memory", str(store), *flags), "someone-elses", "vlpg reindex")


def test_a_store_without_pictures_cannot_be_moved_to_another_encoder(tmp_path):
    from edge.memory.store import Vlpg

    store = tmp_path / "home.vlpg"
    Vlpg.open(store, "someone-elses", "0" * 64, 384).close()
    assert complains(vlpg("reindex", str(store)), "kept no pictures")
    assert complains(vlpg("reindex", str(tmp_path / "nothing.vlpg")), "no store")


def test_ctrl_c_while_asking_ends_without_a_traceback():
    """A robot that never answers: here, nobody at all behind a router that listens."""
    import zenoh

    from edge.link.session import LinkConfig, open_session

    port = f"tcp/127.0.0.1:{free_port()}"
    with open_session(LinkConfig(listen=(port,), multicast_scouting=False)) as session:
        asked = []
        queryable = session.declare_queryable("robot1/find", zenoh.handlers.Callback(asked.append, indirect=False))
        asking = [*VLPG, "find", "teddy", "bear", "--connect", port, "--no-multicast-scouting", "--mode", "client"]
        with subprocess.Popen(asking, stderr=subprocess.PIPE, env=os.environ) as process:
            deadline = time.monotonic() + 30
            while not asked:
                assert time.monotonic() < deadline, "the question never came"
                time.sleep(0.02)
            assert b"teddy bear" in asked[0].payload.to_bytes()
            process.send_signal(signal.SIGINT)
            assert process.wait(20) == 130
            assert b"Traceback" not in process.stderr.read()
        queryable.undeclare()


def test_without_its_extra_the_command_line_says_what_to_install(tmp_path):
    (tmp_path / "typer.py").write_text("raise ModuleNotFoundError('typer')")
    complains(vlpg("status", PYTHONPATH=f"{tmp_path}{os.pathsep}{Path(cli.__file__).parents[1]}"), ".[tools]", code=1)
