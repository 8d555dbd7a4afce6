import zipfile

import numpy as np
import pytest

from firmware_sim.furniture import Furniture
from tools.assets.catalog import open_library
from tools.assets.furniture import belongs, make_pack

TRUCK = """
id#2=Test#truck
name#2=Truck
category#2=Vehicles
model#2=/test/redBox/redBox.obj
width#2=80
depth#2=40
height#2=60
doorOrWindow#2=false
"""


def test_the_pack_holds_furniture_and_names_its_authors(make_library, properties, tmp_path):
    path = make_library(properties=properties + TRUCK, name="BlendSwap-CC-0.sh3f")
    with zipfile.ZipFile(path, "a") as file:
        file.writestr("test/redBox/LICENSE.txt", "Downloaded from http://www.blendswap.com/blends/view/759")
    out = tmp_path / "pack"
    make_pack(tmp_path, out, [], 1)
    pack = Furniture.load(out)
    assert list(pack) == ["red-box"]
    box = pack["red-box"]
    assert (box.name, box.category, box.licence, box.creator) == ("Red box", "Office", "CC0-1.0", "René Box")
    assert box.top == pytest.approx(0.6, abs=0.005)
    np.testing.assert_allclose(np.abs(box.footprint), np.broadcast_to([0.4, 0.2], box.footprint.shape), atol=1e-6)
    front = box.sprites.nearest(-np.pi / 2, 0.2).levels[0]
    assert front[front[..., 3] == 255][:, :3].mean(0).argmax() == 0  # red
    credits = (out / "CREDITS.md").read_text()
    assert "| red-box | Red box | René Box | https://www.blendswap.com/blends/view/759 | CC0 1.0 |" in credits


def test_one_model_can_be_made_anew(make_library, tmp_path):
    make_library(name="BlendSwap-CC-0.sh3f")
    out = tmp_path / "pack"
    make_pack(tmp_path, out, [], 1)
    before = (out / "catalog.json").read_text()
    make_pack(tmp_path, out, ["red-box"], 1)
    assert (out / "catalog.json").read_text() == before


def test_vehicles_and_giants_are_left_out(make_library, properties):
    giant = TRUCK.replace("Vehicles", "Exterior").replace("width#2=80", "width#2=500")
    for extra in (TRUCK, giant):
        library = open_library(make_library(properties=properties + extra))
        assert [belongs(entry) for entry in library] == [True, False]


def test_without_the_library_one_is_told_how_to_get_it(make_library, tmp_path):
    make_library()
    with pytest.raises(FileNotFoundError, match="apt-get install sweethome3d-furniture"):
        make_pack(tmp_path, tmp_path / "pack", [], 1)
