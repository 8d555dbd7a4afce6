from importlib.util import find_spec

import pytest

from models.manifest import ModelError
from tools.models.source import licence_of, open_source


@pytest.mark.parametrize(
    ("readme", "expected"),
    [
        ("---\nlicense: apache-2.0\ntags:\n- clip\n---\n# A model", "apache-2.0"),
        ("---\ntags: []\nlicense: 'mit'\n---\n", "mit"),
        ("---\nlicense: other\nlicense_name: apple-ascl\n---\n", "apple-ascl"),
        ("# A model\nlicense: mit\n", ""),
        ("---\ntags: []\n---\nlicense: mit\n", ""),
        (None, ""),
    ],
)
def test_the_licence_is_what_the_readmes_header_states(tmp_path, readme, expected):
    if readme is not None:
        (tmp_path / "README.md").write_text(readme)
    assert licence_of(tmp_path) == expected


def test_an_empty_folder(tmp_path):
    with pytest.raises(ModelError, match="nothing to import"):
        open_source(str(tmp_path))


def test_a_model_that_needs_no_import(toy):
    with pytest.raises(ModelError, match="is a vlpg model already"):
        open_source(str(toy))


def test_a_file_alone(tmp_path):
    (tmp_path / "weights.pt").write_bytes(b"")
    with pytest.raises(ModelError, match="--checkpoint FILE"):
        open_source(str(tmp_path / "weights.pt"))


def test_a_checkpoint_for_a_folder(tmp_path):
    with pytest.raises(ModelError, match="--checkpoint goes with"):
        open_source(str(tmp_path), tmp_path / "weights.pt")


@pytest.mark.parametrize("source", ["./nothing", "/nowhere/at/all", "~/nothing-of-that-name", "../nothing"])
def test_a_folder_that_is_not_there(source):
    with pytest.raises(ModelError, match="There is no folder"):
        open_source(source)


@pytest.mark.skipif(find_spec("torch") is not None, reason="the import extra is installed")
@pytest.mark.parametrize("source", ["ViT-B-32@openai", "openai/clip-vit-base-patch32"])
def test_without_the_extra_it_is_named(source, monkeypatch):
    monkeypatch.setenv("HF_ENDPOINT", "http://127.0.0.1:1")
    with pytest.raises(ModelError, match=r"pip install '.\[import\]'"):
        open_source(source)
