"""What the robot reports about itself, as it comes out of the wire's bytes again."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from edge.link.reports import areas, cancelled_reply, find_reply, map_reply, tour_reply
from edge.link.requests import pack, unpack
from edge.mapping.grid import GridFrame
from edge.missions.map_home import HomeMapped
from edge.missions.search import Claim, Outcome
from edge.missions.sighting import Sighting
from edge.perception.detection import Detection
from edge.planning.local_search import Replan
from edge.planning.viewpoint import Viewpoint
from tests.edge.mapping.conftest import draw

GRID = draw("####\n#. .\n....", resolution=0.5)


def robot(viewed, lost=False, nodes=3):
    return SimpleNamespace(
        grid=GRID,
        coverage=SimpleNamespace(viewed=viewed),
        pose=np.array([1.0, 2.0, 0.5]),
        localizer=SimpleNamespace(lost=lost),
        memory=range(nodes),
    )


def over_the_wire(reply):
    return unpack(type(reply), pack(reply))


def test_the_map_is_told_as_ros_tells_it():
    path = [(0.0, 0.1), (0.5, 0.2)]
    told = over_the_wire(map_reply(GRID, path))
    assert told.cells.numpy().tolist() == [[0, 0, 0, 0], [100, 0, -1, 0], [100, 100, 100, 100]]
    assert told.origin == GRID.frame.origin and told.resolution == 0.5
    assert told.path.numpy() == pytest.approx(np.array(path))
    assert over_the_wire(map_reply(GRID, [])).path.shape == (0, 2)


def test_of_the_free_floor_only_what_is_free_was_looked_at():
    viewed = np.zeros((3, 4), np.uint8)
    assert areas(robot(viewed)) == (6 * 0.25, 0.0)
    viewed[:2] = 1  # the wall and the unknown cell, too
    assert areas(robot(viewed)) == (1.5, 1.5)
    assert areas(robot(np.ones((9, 9), np.uint8))) == (1.5, 0.0)  # the map has grown, and nobody has looked since


@pytest.mark.parametrize(
    ("complete", "lost", "status"), [(True, False, "complete"), (False, True, "lost"), (False, False, "timeout")]
)
def test_how_a_tour_ended(complete, lost, status):
    told = over_the_wire(tour_reply(HomeMapped(complete, 12.5, 3.0, 20.0, 3), robot(None, lost)))
    assert (told.status, told.duration, told.distance, told.nodes) == (status, 12.5, 3.0, 3)


def test_what_was_found_is_told_whole():
    seen = Sighting(4.0, np.zeros(3), Detection((10.0, 20.0, 60.5, 80.0), 0.8, None), -0.1, 1.5, np.array([2.0, 3.0]))
    places = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [2.0, 0.0, 1.0]])
    outcome = Outcome(
        "found",
        Claim(seen, 0.7, 0.9),
        0.9,
        30.0,
        7.5,
        [Viewpoint(places[2], 0.6, np.array([2, 0]), 2.0)],
        places,
        [Replan(GridFrame((1.0, -1.0), 0.1, (1, 3)), np.array([[0.0, 0.5, 1.0]], np.float32), places[1])],
    )
    rgb = np.full((40, 60, 3), (200, 30, 30), np.uint8)
    told = over_the_wire(find_reply("red ball", outcome, robot(None), SimpleNamespace(rgb=rgb)))
    assert (told.status, told.object, told.pose) == ("found", "red ball", (1.0, 2.0, 0.5))
    assert (told.position, told.bearing, told.depth, told.score) == ((2.0, 3.0), -0.1, 1.5, 0.8)
    assert (told.box, told.confidence, told.duration) == ((10.0, 20.0, 60.5, 80.0), 0.9, 30.0)
    assert told.hypotheses[0].members == [(2.0, 0.0, 1.0), (0.0, 0.0, 0.0)]
    assert told.replans[0].probability.numpy().tolist() == [[0, 128, 255]]
    blue, green, red = cv2.imdecode(np.frombuffer(told.jpeg, np.uint8), cv2.IMREAD_COLOR)[20, 30]
    assert red > 180 and max(blue, green) < 50


def test_what_was_not_reached_is_left_out():
    told = over_the_wire(find_reply("ball", Outcome("not in memory", None, 0.0, 0.0, 0.0), robot(None), None))
    assert (told.position, told.score, told.box, told.jpeg) == (None, None, None, None) and told.hypotheses == []
    assert over_the_wire(cancelled_reply("ball", robot(None), None, 2.0, 0.5)).status == "cancelled"
