import numpy as np
import pytest

from tools.assets.catalog import open_library
from tools.assets.obj_model import load_mesh
from tools.assets.shape import MAX_SEGMENTS, footprint, outline, top

SIDES = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def boxes(make_library, *parts, size):
    """Mesh of boxes (x0, x1, y0, y1, z0, z1) in the furniture frame [m] with the overall ``size``."""
    lines = []
    for number, (x0, x1, y0, y1, z0, z1) in enumerate(parts):
        for z in (z0, z1):
            lines += [f"v {x} {z} {-y}" for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
        lines += ["f " + " ".join(str(8 * number + corner + 1) for corner in side) for side in SIDES]
    width, depth, height = (100 * side for side in size)
    properties = f"id#1=Test#it\nmodel#1=/test/redBox/redBox.obj\nwidth#1={width}\ndepth#1={depth}\nheight#1={height}\n"
    library = open_library(make_library(properties=properties, obj="\n".join(lines)))
    return load_mesh(library, library.entries[0])


@pytest.fixture
def table(make_library):
    legs = [(x, x + 0.06, y, y + 0.06, 0.0, 0.7) for x in (-0.6, 0.54) for y in (-0.4, 0.34)]
    return boxes(make_library, (-0.6, 0.6, -0.4, 0.4, 0.7, 0.75), *legs, size=(1.2, 0.8, 0.75))


def area(polygon):
    x, y = polygon.T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


def test_footprint_of_a_table_is_its_plate(table):
    hull = footprint(table)
    assert area(hull) == pytest.approx(0.96, rel=1e-3)  # counter-clockwise, so positive
    np.testing.assert_allclose(np.abs(hull), np.broadcast_to([0.6, 0.4], hull.shape), atol=1e-6)


def test_what_is_above_the_robot_is_not_in_the_footprint(make_library):
    parasol = boxes(make_library, (-0.05, 0.05, -0.05, 0.05, 0, 2), (-1, 1, -1, 1, 1.9, 2), size=(2, 2, 2))
    assert area(footprint(parasol)) == pytest.approx(0.01, rel=1e-3)


def test_outline_of_a_table_is_its_legs(table):
    segments = outline(table)
    assert 16 <= len(segments) <= MAX_SEGMENTS
    points = segments.reshape(-1, 2)
    distance = np.maximum(0.54 - np.abs(points[:, 0]), 0.34 - np.abs(points[:, 1]))  # from the legs' inner sides
    assert distance.max() < 0.006
    assert np.abs(points).max(0) == pytest.approx([0.6, 0.4], abs=0.006)


def test_what_the_lidar_passes_over_has_no_outline(make_library):
    assert outline(boxes(make_library, (-1, 1, -1, 1, 0, 0.2), size=(2, 2, 0.2))).shape == (0, 2, 2)


def test_a_fence_of_many_bars_stays_within_the_limit(make_library):
    bars = [(x, x + 0.01, 0, 0.01, 0, 1) for x in np.linspace(0, 2, 41)]
    segments = outline(boxes(make_library, *bars, size=(2.01, 0.01, 1)))
    assert 0 < len(segments) <= MAX_SEGMENTS
    points = segments.reshape(-1, 2)
    assert np.ptp(points[:, 0]) == pytest.approx(2.01, abs=0.02)


def test_top_is_where_there_is_level_area(table, make_library):
    assert top(table, None) == pytest.approx(0.75, abs=0.005)
    assert top(table, -0.01) is None  # the catalog says that nothing stands on it
    chair = boxes(make_library, (0, 0.4, 0, 0.4, 0, 0.45), (0, 0.4, 0.36, 0.4, 0, 0.9), size=(0.4, 0.4, 0.9))
    assert top(chair, None) == pytest.approx(0.45, abs=0.01)  # the seat, not the rim of the back
    rail = boxes(make_library, (0, 2, 0, 0.05, 0, 1), size=(2, 0.05, 1))
    assert top(rail, 1.0) is None
