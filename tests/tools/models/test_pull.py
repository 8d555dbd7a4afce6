import json

import pytest

from models.manifest import Manifest, ModelError, folders, resolve
from tools.models.download import TRIES
from tools.models.pull import pull


def edit(folder, change):
    fields = json.loads((folder / "manifest.json").read_text())
    change(fields)
    (folder / "manifest.json").write_text(json.dumps(fields))


def test_a_whole_model(serve, toy, shelf):
    progress = []
    manifest = pull(serve(toy).url, progress=lambda *told: progress.append(told))
    assert manifest.folder == resolve("toy") == shelf / "toy"
    manifest.verify()
    assert manifest.source == "the tests" and manifest.licence == "CC0-1.0" and manifest.measured == {"image_ms": 1.5}
    assert {path.name: path.read_bytes() for path in manifest.folder.iterdir() if path.name != "manifest.json"} == {
        path.name: path.read_bytes() for path in toy.iterdir() if path.name != "manifest.json"
    }
    assert [path.name for path in shelf.iterdir()] == ["toy"]
    last = {name: (done, total) for name, done, total in progress}
    assert set(last) == {file.name for file in manifest.files} and all(done == total for done, total in last.values())


def test_under_another_name(serve, toy, shelf):
    assert pull(serve(toy).url + "/", "mine").name == "mine"
    assert Manifest.load(resolve("mine")).digest == Manifest.load(toy).digest


def test_a_card_is_not_needed(serve, toy, shelf):
    (toy / "MODEL_CARD.md").unlink()
    pull(serve(toy).url)
    assert not (shelf / "toy" / "MODEL_CARD.md").exists()


def test_an_interrupted_pull_goes_on(serve, toy, shelf):
    server = serve(toy)
    server.cuts["text.onnx"] = [1000] * TRIES
    with pytest.raises(ModelError, match="run the command again"):
        pull(server.url)
    assert "toy" not in folders()
    server.asked.clear()
    pull(server.url).verify()
    assert [path for path, *_ in server.asked] == ["manifest.json", "text.onnx", "tokenizer.json", "MODEL_CARD.md"]
    assert server.asked[1][1] == f"bytes={1000 * TRIES}-"
    assert [path.name for path in shelf.iterdir()] == ["toy"]


def test_what_an_earlier_pull_of_something_else_left_is_cleared(serve, toy, shelf):
    (shelf / ".toy.part").mkdir(parents=True)
    (shelf / ".toy.part" / "other.bin.part").write_bytes(b"left")
    assert not (pull(serve(toy).url).folder / "other.bin.part").exists()


def test_a_damaged_file_is_named_and_no_model_appears(serve, toy, shelf):
    (toy / "text.onnx").write_bytes(b"damage" * 50_000)
    with pytest.raises(ModelError, match="text.onnx is damaged"):
        pull(serve(toy).url)
    assert "toy" not in folders()


@pytest.mark.parametrize("name", ["../up", "/etc/passwd", ".hidden", "a\\b", ""])
def test_a_manifest_leads_nowhere_else(serve, toy, shelf, name):
    edit(toy, lambda fields: fields["files"][0].update(name=name))
    with pytest.raises(ModelError, match="not a vlpg model's manifest"):
        pull(serve(toy).url)
    assert list(shelf.iterdir()) == []


def test_every_graph_must_be_listed(serve, toy, shelf):
    edit(toy, lambda fields: fields["image"].update(graph="/other/image.onnx"))
    with pytest.raises(ModelError, match="names /other/image.onnx"):
        pull(serve(toy).url)


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b'{"name": "toy"}', b"<html>", b"\xff\xfe"])
def test_what_is_no_manifest(serve, toy, shelf, content):
    (toy / "manifest.json").write_bytes(content)
    with pytest.raises(ModelError, match="not a vlpg model's manifest|is no name"):
        pull(serve(toy).url)
    assert not shelf.exists() or list(shelf.iterdir()) == []


def test_a_place_without_a_model(serve, tmp_path, shelf):
    with pytest.raises(ModelError, match="no vlpg model at.*vlpg models import"):
        pull(serve(tmp_path).url)


def test_a_taken_name_is_told_before_anything_is_fetched(serve, toy, shelf):
    server = serve(toy)
    pull(server.url)
    server.asked.clear()
    with pytest.raises(ModelError, match="remove toy"):
        pull(server.url)
    assert len(server.asked) == 1


@pytest.fixture
def hub(serve, toy, tmp_path, monkeypatch):
    """A hub with the toy as me/toy, at main and at v2."""
    for revision in ("main", "v2"):
        place = tmp_path / "hub" / "me" / "toy" / "resolve"
        place.mkdir(parents=True, exist_ok=True)
        (place / revision).symlink_to(toy)
    server = serve(tmp_path / "hub")
    monkeypatch.setenv("HF_ENDPOINT", server.url + "/")
    return server


def test_from_a_hub(hub, shelf, monkeypatch):
    monkeypatch.setenv("HF_TOKEN", "secret")
    pull("me/toy").verify()
    assert hub.asked[0] == ("me/toy/resolve/main/manifest.json", None, "Bearer secret")
    pull("me/toy@v2", "second").verify()
    assert hub.asked[-1][0] == "me/toy/resolve/v2/MODEL_CARD.md"


def test_the_token_is_for_the_hub_only(serve, toy, shelf, monkeypatch):
    monkeypatch.setenv("HF_TOKEN", "secret")
    server = serve(toy)
    pull(server.url)
    assert {authorization for *_, authorization in server.asked} == {None}


def test_offline(hub, shelf, monkeypatch):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    with pytest.raises(ModelError, match="HF_HUB_OFFLINE is set"):
        pull("me/toy")
    assert hub.asked == []


def test_a_hub_that_cannot_be_reached(shelf, monkeypatch):
    monkeypatch.setenv("HF_ENDPOINT", "http://127.0.0.1:1")
    monkeypatch.delenv("HF_HUB_OFFLINE", raising=False)
    with pytest.raises(ModelError, match="cannot be reached.*HF_ENDPOINT"):
        pull("me/toy")


@pytest.mark.parametrize("source", ["toy", "", "ftp://x/y", "a/b/c", "me/toy@", "../toy", "/x"])
def test_what_is_neither_address_nor_repository(source, shelf):
    with pytest.raises(ModelError, match="neither an http|cannot be reached"):
        pull(source)
