"""A furniture library of one model: a box with a red front, a blue back, a textured right-hand side and a green top."""

import zipfile

import cv2
import numpy as np
import pytest

PROPERTIES = """# a comment
name=Test library
version=0.3
license=CC0
id#1=Test#redBox
name#1=Red box
tags#1=Blend Swap, Storage, Toy
category#1=Office
model#1=/test/redBox/redBox.obj
multiPartModel#1=true
width#1=80
depth#1=40
height#1=60
dropOnTopElevation#1=60
movable#1=true
doorOrWindow#1=false
creator#1=Ren\\u00e9 \\
  Box
"""
# OBJ: x right, y up, z towards the viewer, so the front is at z = 1.
OBJ = """mtllib redBox.mtl
v 0 0 1
v 2 0 1
v 2 5 1
v 0 5 1
v 0 0 -1
v 2 0 -1
v 2 5 -1
v 0 5 -1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl red
f 1 2 3 4
usemtl blue
f -3 -4 -1 -2
usemtl checked
f 2/1 6/2 7/3 3/4
usemtl unknown
f 5 1 4 8
usemtl green
f 4 3 7 8
f 1 5 6 2
"""
MTL = """newmtl red
Kd 1 0 0
newmtl blue
Kd 0 0 1
newmtl green
Kd 0 1 0
newmtl checked
Kd 0 0 0
map_Kd TEXTURE.png
"""


@pytest.fixture
def make_library(tmp_path):
    """Writes a library from the texts above; any of them can be replaced."""

    def make(properties=PROPERTIES, obj=OBJ, mtl=MTL, name="Test.sh3f"):
        texture = np.zeros((8, 8, 3), np.uint8)
        texture[:4] = 255  # white above, black below
        path = tmp_path / name
        with zipfile.ZipFile(path, "w") as file:
            file.writestr("PluginFurnitureCatalog.properties", properties.encode("latin-1"))
            file.writestr("test/redBox/redBox.obj", obj)
            file.writestr("test/redBox/redBox.mtl", mtl)
            file.writestr("test/redBox/texture.png", cv2.imencode(".png", texture)[1].tobytes())
        return path

    return make


@pytest.fixture
def properties():
    """The catalog of that library, to add entries to."""
    return PROPERTIES
