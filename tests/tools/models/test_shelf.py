import pytest

from models.manifest import SHIPPED, ModelError, folders
from tools.models.shelf import new_model, remove


def make(name):
    with new_model(name) as folder:
        (folder / "manifest.json").write_text("{}")


def test_a_model_appears_when_it_is_finished(shelf):
    with new_model("mine") as folder:
        (folder / "manifest.json").write_text("{}")
        assert "mine" not in folders()
    assert folders()["mine"] == shelf / "mine"
    assert [path.name for path in shelf.iterdir()] == ["mine"]


def test_an_error_leaves_nothing(shelf):
    with pytest.raises(KeyError), new_model("mine") as folder:
        (folder / "image.onnx").write_text("half")
        raise KeyError
    assert list(shelf.iterdir()) == []


@pytest.mark.parametrize("name", ["", ".", "..", "a/b", "../up", ".hidden", "a b", "-x", "x" * 65, "a\n"])
def test_a_name_that_is_no_plain_one(shelf, name):
    with pytest.raises(ModelError, match="is no name for a model"), new_model(name):
        pass
    assert not shelf.exists()


def test_a_taken_name(shelf):
    make("mine")
    with pytest.raises(ModelError, match="`vlpg models remove mine` first"), new_model("mine"):
        pass
    with pytest.raises(ModelError, match="is shipped"), new_model("lite0-minilm"):
        pass


def test_a_name_that_is_taken_while_the_model_is_made(shelf):
    with pytest.raises(ModelError, match="remove mine"), new_model("mine"):
        make("mine")
    assert [path.name for path in shelf.iterdir()] == ["mine"]


def test_removing(shelf):
    make("mine")
    make("other")
    assert remove("mine") == shelf / "mine"
    assert [path.name for path in shelf.iterdir()] == ["other"]
    with pytest.raises(ModelError, match="no model named mine.*Yours: other"):
        remove("mine")


@pytest.mark.parametrize("name", ["../shelf", "/", "nothing", ""])
def test_only_names_are_removed(shelf, name):
    make("mine")
    with pytest.raises(ModelError):
        remove(name)
    assert (shelf / "mine").is_dir()


def test_removing_what_an_interrupted_pull_has_left(shelf):
    (shelf / ".mine.part").mkdir(parents=True)
    assert remove("mine") == shelf / ".mine.part"
    assert list(shelf.iterdir()) == []


def test_the_shipped_model_stays(shelf):
    with pytest.raises(ModelError, match="shipped"):
        remove("lite0-minilm")
    assert (SHIPPED / "lite0-minilm" / "manifest.json").is_file()
