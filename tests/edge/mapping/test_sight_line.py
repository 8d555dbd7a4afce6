"""How far a drawn map lets the camera see, against the distance to its walls in closed form."""

import numpy as np
import pytest

from edge.camera import CameraModel
from edge.mapping.sight_line import mapped_depth
from edge.pose import transform
from tests.edge.mapping.conftest import draw

CAMERA = CameraModel(ahead=0.1, max_depth=5.0)
ROOM = draw("\n".join(["#" * 60, *["#" + "." * 58 + "#"] * 38, "#" * 60]))  # 6 x 4 m
COLUMNS = np.linspace(0, CAMERA.width - 1, 33)


def to_walls(pose):
    """Depth [m] of the first wall of ROOM in each of COLUMNS, by similar triangles."""
    eye = transform(pose, np.array([[CAMERA.ahead, CAMERA.left]]))[0]
    bearings = pose[2] + CAMERA.bearing(COLUMNS)
    along = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    reach = np.where(along > 0, (np.array([5.9, 3.9]) - eye) / along, (0.1 - eye) / along).min(axis=1)
    return reach * np.cos(CAMERA.bearing(COLUMNS))


@pytest.mark.parametrize("pose", [(1.0, 2.0, 0.1), (3.0, 1.0, 1.0), (4.5, 3.0, -2.4), (2.2, 2.7, 3.1)])
def test_the_first_wall_ends_the_sight(pose):
    wanted = np.minimum(to_walls(np.array(pose)), CAMERA.max_depth)
    found = mapped_depth(ROOM, CAMERA, np.array(pose), COLUMNS)
    # A cell's half for where its obstacle begins; on a slant the ray may meet the corner of a cell before its wall.
    assert found == pytest.approx(wanted, abs=0.15)


def test_what_is_unknown_or_off_the_map_hides_nothing():
    nothing = draw(".." + "\n" + "  ")
    assert (mapped_depth(nothing, CAMERA, np.array([0.1, 0.1, 0.7]), COLUMNS) == CAMERA.max_depth).all()


def test_no_column_no_depth():
    assert mapped_depth(ROOM, CAMERA, np.array([1.0, 2.0, 0.0]), []).shape == (0,)
