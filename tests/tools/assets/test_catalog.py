import pytest

from tools.assets.catalog import find_libraries, open_library, slug


def test_entry_says_what_the_properties_say(make_library):
    library = open_library(make_library())
    (entry,) = library
    assert (library.version, len(library)) == ("0.3", 1)
    assert (entry.library, entry.id, entry.name) == ("Test", "red-box", "Red box")
    assert entry.tags == ("Storage", "Toy")  # the provider is not a tag
    assert entry.size == pytest.approx((0.8, 0.4, 0.6))
    assert entry.drop_on_top == pytest.approx(0.6)
    assert entry.elevation is None
    assert entry.creator == "René Box"
    assert entry.licence == "CC0"
    assert entry.multi_part and not entry.door_or_window
    assert library.read("TEST/redbox/redBox.OBJ").startswith(b"mtllib")


def test_equal_ids_are_told_apart(make_library):
    size = "width#{0}=1\ndepth#{0}=1\nheight#{0}=1\n"
    text = "".join(f"id#{n}=Test#{name}\n" + size.format(n) for n, name in ((1, "redBox"), (2, "Red box")))
    assert [entry.id for entry in open_library(make_library(properties=text))] == ["red-box", "red-box-2"]


@pytest.mark.parametrize("text", ["teddyBear", "Teddy bear", "teddy_bear", " Teddy-Bear "])
def test_slug(text):
    assert slug(text) == "teddy-bear"


def test_missing_and_foreign_files_are_named(tmp_path):
    with pytest.raises(ValueError, match="no furniture library at"):
        open_library(tmp_path / "none.sh3f")
    (tmp_path / "bad.sh3f").write_bytes(b"not a zip")
    with pytest.raises(ValueError, match="not a Sweet Home 3D furniture library"):
        open_library(tmp_path / "bad.sh3f")


def test_an_empty_folder_tells_how_to_install(tmp_path, make_library):
    with pytest.raises(FileNotFoundError, match="apt-get install sweethome3d-furniture"):
        find_libraries(tmp_path / "empty")
    path = make_library()
    assert find_libraries(tmp_path) == {"Test": path}
