import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tools.assets.catalog import open_library
from tools.assets.obj_model import _cut, load_mesh

PROPERTIES = "id#1=Test#redBox\nmodel#1=/test/redBox/redBox.obj\nwidth#1=80\ndepth#1=40\nheight#1=60\n"


def load(path):
    library = open_library(path)
    return load_mesh(library, library.entries[0])


def face(mesh, material):
    """Corners (K, 3, 3) of the triangles with the material of this colour."""
    wanted = [i for i, m in enumerate(mesh.materials) if np.allclose(m.colour, material) and m.texture is None]
    return mesh.corners[np.isin(mesh.material, wanted)]


def test_the_box_has_the_catalogs_size_and_stands_on_the_origin(make_library):
    mesh = load(make_library())
    corners = mesh.corners.reshape(-1, 3)
    np.testing.assert_allclose(corners.min(0), [-0.4, -0.2, 0.0], atol=1e-6)
    np.testing.assert_allclose(corners.max(0), [0.4, 0.2, 0.6], atol=1e-6)
    assert len(mesh.corners) == 12


def test_the_front_faces_minus_y_and_the_top_up(make_library):
    mesh = load(make_library())
    assert (face(mesh, (1, 0, 0))[..., 1] == np.float32(-0.2)).all()
    assert (face(mesh, (0, 0, 1))[..., 1] == np.float32(0.2)).all()
    normals = mesh.normals[mesh.material == [i for i, m in enumerate(mesh.materials) if m.texture is not None][0]]
    np.testing.assert_allclose(normals, np.broadcast_to([1.0, 0, 0], normals.shape), atol=1e-6)


def test_textures_are_found_whatever_the_case_of_their_name(make_library):
    textured = [m for m in load(make_library()).materials if m.texture is not None]
    assert len(textured) == 1
    assert textured[0].texture.shape == (8, 8, 4)
    assert textured[0].texture[0, 0].tolist() == [255, 255, 255, 255]


def test_a_missing_mtl_gives_grey(make_library):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    mesh = load(make_library(obj=corners + "mtllib none.mtl\nusemtl wood\nf 1 2 3\nf 1 2 4\n"))
    assert len(mesh.corners) == 2
    assert all(np.allclose(m.colour, 0.7) for m in mesh.materials)


def test_model_rotation_turns_the_obj(make_library):
    mesh = load(make_library(properties=PROPERTIES + "modelRotation#1=0 0 1 0 1 0 -1 0 0\n"))
    assert (face(mesh, (1, 0, 0))[..., 0] == np.float32(0.4)).all()  # a quarter turn took the front to the right


def test_a_model_without_faces_is_named(make_library):
    with pytest.raises(ValueError, match="redBox.obj in .* holds no faces"):
        load(make_library(obj="v 0 0 0\n"))


@given(st.lists(st.floats(0.2, 1.0), min_size=4, max_size=12), st.integers(0, 5), st.booleans())
def test_cutting_a_polygon_keeps_its_area(radii, orientation, clockwise):
    angles = np.arange(len(radii)) / len(radii) * 2 * np.pi
    flat = np.stack([radii * np.cos(angles), radii * np.sin(angles)], 1)[:: -1 if clockwise else 1]
    axes = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)][orientation]
    polygon = np.insert(flat, 2, 0.3, axis=1)[:, axes]
    x, y = flat.T
    area = abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2
    triangles = polygon[np.array(_cut(polygon))]
    parts = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1) / 2
    assert len(triangles) == len(radii) - 2
    assert parts.sum() == pytest.approx(area, rel=1e-6)  # overlaps or triangles outside would make it more
