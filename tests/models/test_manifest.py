import json
import shutil

import pytest

from models.manifest import SHIPPED, Manifest, ModelError, folders, resolve, user_folder


@pytest.fixture
def folder(tmp_path):
    """A copy of the shipped folder's small files: the manifest with what it must have, and one file that it lists."""
    source = resolve()
    raw = json.loads((source / "manifest.json").read_text())
    raw.pop("measured")
    kept = [entry for entry in raw["files"] if entry["name"] == "tokenizer.json"]
    (tmp_path / "manifest.json").write_text(json.dumps(raw | {"files": kept}))
    shutil.copy(source / "tokenizer.json", tmp_path)
    return tmp_path


def edit(folder, **changes):
    path = folder / "manifest.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_the_shipped_model_is_intact():
    manifest = Manifest.load(resolve())
    manifest.verify()
    assert manifest.name == "lite0-minilm" and manifest.dim == 384


def test_a_robot_that_leaves_text_to_a_host_needs_no_text_tower(tmp_path):
    source = Manifest.load(resolve())
    for file in source.image_files:
        shutil.copy(source.folder / file.name, tmp_path)
    shutil.copy(source.folder / "manifest.json", tmp_path)
    copied = Manifest.load(tmp_path)
    copied.verify(text=False)
    assert copied.digest == source.digest and not any("text" in file.name for file in copied.image_files)
    with pytest.raises(ModelError, match="text.onnx is missing|tokenizer.json is missing"):
        copied.verify()


def test_every_file_of_the_folder_but_manifest_and_card_is_listed():
    manifest = Manifest.load(resolve())
    there = {path.name for path in manifest.folder.iterdir() if path.suffix not in (".md", ".jpg")} - {"manifest.json"}
    assert there == {file.name for file in manifest.files}


def test_what_need_not_be_stated_is_empty(folder):
    manifest = Manifest.load(folder)
    assert (manifest.measured, manifest.source, manifest.licence) == ({}, "", "")
    assert all(isinstance(value, float) for value in Manifest.load(resolve()).measured.values())


def test_a_missing_file_is_named(folder):
    (folder / "tokenizer.json").unlink()
    with pytest.raises(ModelError, match="tokenizer.json is missing; restore"):
        Manifest.load(folder).verify()


@pytest.mark.parametrize("damage", [lambda data: data[:-1], lambda data: data[:-1] + b"x"])
def test_a_damaged_file_is_named(folder, damage):
    path = folder / "tokenizer.json"
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(ModelError, match="tokenizer.json is damaged"):
        Manifest.load(folder).verify()


def test_the_digest_follows_the_files_only(folder):
    before = Manifest.load(folder).digest
    edit(folder, logit_scale=1.0)
    assert Manifest.load(folder).digest == before
    edit(folder, files=[{"name": "tokenizer.json", "sha256": "0" * 64, "size": 1}])
    assert Manifest.load(folder).digest != before


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(ModelError, match="no model named clip-vit.*lite0-minilm"):
        resolve("clip-vit")


def test_a_folder_is_resolved_by_path(folder):
    assert resolve(folder) == folder


@pytest.mark.parametrize("content", ["", "{", '{"name": "x"}', "[]", "\x00"])
def test_a_broken_manifest_is_one_sentence(tmp_path, content):
    (tmp_path / "manifest.json").write_text(content)
    with pytest.raises(ModelError, match="manifest.json"):
        Manifest.load(tmp_path)


def test_a_folder_without_manifest(tmp_path):
    with pytest.raises(ModelError, match="no model in"):
        Manifest.load(tmp_path)


def test_what_is_optional(folder):
    manifest = Manifest.load(folder)
    assert manifest.text.pad_id is None and manifest.source == manifest.licence == "" and manifest.measured == {}
    text = {"graph": "text.onnx", "tokenizer": "tokenizer.json", "context_length": 64, "pad_id": 1}
    edit(folder, text=text, source="a hub", licence="MIT", measured={"image_ms": 3.5})
    manifest = Manifest.load(folder)
    assert manifest.text.pad_id == 1 and manifest.source == "a hub" and manifest.licence == "MIT"
    assert manifest.measured == {"image_ms": 3.5}


@pytest.mark.parametrize("name", ["../x", "/x", "a/b", "a\\b", ".x", ""])
def test_a_file_lies_in_the_folder(folder, name):
    edit(folder, files=[{"name": name, "sha256": "0" * 64, "size": 1}])
    with pytest.raises(ModelError, match="plain name"):
        Manifest.load(folder)


def test_the_users_models_are_found_by_name(folder, tmp_path, monkeypatch):
    monkeypatch.setenv("VLPG_MODELS", str(tmp_path / "shelf"))
    assert list(folders()) == ["lite0-minilm"]
    for name in ("mine", "lite0-minilm", ".hidden"):
        (tmp_path / "shelf" / name).mkdir(parents=True)
        shutil.copy(folder / "manifest.json", tmp_path / "shelf" / name)
    assert folders() == {"lite0-minilm": SHIPPED / "lite0-minilm", "mine": tmp_path / "shelf" / "mine"}
    assert resolve("mine") == tmp_path / "shelf" / "mine"
    with pytest.raises(ModelError, match="Known: lite0-minilm, mine;"):
        resolve("yours")


def test_where_the_users_models_are(monkeypatch):
    monkeypatch.setenv("HOME", "/home/me")
    monkeypatch.delenv("VLPG_MODELS", raising=False)
    assert str(user_folder()) == "/home/me/.local/share/vlpg/models"
    monkeypatch.setenv("VLPG_MODELS", "/data/models")
    assert str(user_folder()) == "/data/models"


def test_relevance_is_a_rising_probability():
    relevance = Manifest.load(resolve()).relevance
    low, high = relevance([-1.0, 1.0])
    assert 0 <= low < 0.5 < high <= 1
