import numpy as np
import pytest

from tools.assets.catalog import open_library
from tools.assets.obj_model import load_mesh
from tools.assets.rasterizer import axes, render

FRONT, RIGHT, BACK = -np.pi / 2, 0.0, np.pi / 2


@pytest.fixture
def box(make_library):
    library = open_library(make_library())
    return load_mesh(library, library.entries[0])


def hue(view, part=np.s_[:, :]):
    """Index of the strongest channel where something is drawn."""
    seen = view.rgba[part].reshape(-1, 4)
    return int(seen[seen[:, 3] == 255][:, :3].sum(0).argmax())


def test_axes_are_a_right_handed_frame():
    for yaw, pitch in ((0.3, 0.2), (-2.0, -0.4), (FRONT, 0.0)):
        frame = axes(yaw, pitch)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(np.cross(frame[0], frame[2]), frame[1], atol=1e-12)
    np.testing.assert_allclose(axes(FRONT, 0.0), [[1, 0, 0], [0, 0, 1], [0, 1, 0]], atol=1e-12)


def test_each_yaw_sees_its_side(box):
    assert hue(render(box, FRONT, 0.0, 64)) == 0
    assert hue(render(box, BACK, 0.0, 64)) == 2
    assert hue(render(box, FRONT, np.pi / 2, 64)) == 1


def test_the_silhouette_is_the_projected_box(box):
    view = render(box, FRONT, 0.0, (100, 80), scale=100.0)
    assert view.scale == 100.0
    rows, columns = np.nonzero(view.rgba[..., 3] > 127)
    assert (columns.min(), columns.max()) == (10, 89)  # 0.8 m about the middle
    assert (rows.min(), rows.max()) == (10, 69)  # 0.6 m


def test_depth_is_that_of_the_box(box):
    view = render(box, FRONT, 0.0, 64)
    np.testing.assert_allclose(view.depth[20:44, 20:44], -0.2, atol=1e-6)
    slanted = render(box, FRONT, 0.5, (101, 101), scale=50.0)
    # In the middle one looks at the centre of the box: the front face is 0.2 m before it, along a slanted ray.
    assert slanted.depth[50, 50] == pytest.approx(-0.2 / np.cos(0.5), abs=2e-3)
    assert np.isnan(slanted.depth[0, 0]) and slanted.rgba[0, 0, 3] == 0


def test_textures_are_upright(box):
    view = render(box, RIGHT, 0.0, 64)
    assert view.rgba[16, 32, 0] > 150  # white above
    assert view.rgba[48, 32, 0] < 30  # black below


def test_by_default_the_whole_model_fits(box):
    for yaw in np.linspace(-3, 3, 5):
        alpha = render(box, yaw, 0.4, 40).rgba[..., 3]
        assert not (alpha[0].any() or alpha[-1].any() or alpha[:, 0].any() or alpha[:, -1].any())
        assert alpha.any(0).sum() >= 36 or alpha.any(1).sum() >= 36


def test_glass_is_see_through_and_has_the_depth_of_its_surface(make_library):
    library = open_library(make_library(mtl="newmtl red\nKd 1 0 0\nd 0.6\nnewmtl blue\nKd 0 0 1\n"))
    view = render(load_mesh(library, library.entries[0]), FRONT, 0.0, 64)
    red, _, blue, alpha = view.rgba[32, 32]
    assert red > 100 and blue > 50  # the back shines through the front
    assert alpha == 255
    assert view.depth[32, 32] == pytest.approx(-0.2)
