"""Standing where a place is seen: rooms drawn by hand, the answer checked along the line of sight."""

import cv2
import numpy as np
import pytest

from edge.mapping.grid import GridFrame
from edge.planning.standpoint import standpoint, stands_before

FRAME = GridFrame((-6.0, -4.0), 0.05, (160, 240))  # 12 x 8 m


def room(*boxes):
    """Occupied and reachable ``(R, C)`` of a room of 10 x 7 m with ``boxes`` (x0, y0, x1, y1) [m] in it."""
    occupied = np.zeros(FRAME.shape, bool)
    for x0, y0, x1, y1 in ((-5, -3.5, 5, -3.4), (-5, 3.4, 5, 3.5), (-5, -3.5, -4.9, 3.5), (4.9, -3.5, 5, 3.5), *boxes):
        (top, left), (bottom, right) = FRAME.to_cell([x0, y0]), FRAME.to_cell([x1, y1])
        occupied[top:bottom, left:right] = True
    clear = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, 5) * 0.05 > 0.18
    labels = cv2.connectedComponents(clear.astype(np.uint8))[1]
    return occupied, labels == labels[tuple(FRAME.to_cell([-2.0, 0.0]))]


def stand(place, robot, boxes=(), near=1.8):
    occupied, reachable = room(*boxes)
    found = standpoint(place, robot, near, reachable, occupied, FRAME)
    assert reachable[tuple(FRAME.to_cell(found))]
    return found


def free_line(a, b, boxes):
    line = np.linspace(a, b, 400)
    return not any(((line > box[:2]) & (line < box[2:])).all(axis=1).any() for box in map(np.array, boxes))


def test_in_the_open_it_is_straight_ahead_at_the_distance_asked_for():
    found = stand((3.0, 0.0), (-2.0, 0.0, 0.0))
    assert found == pytest.approx([1.2, 0.0], abs=0.1)


def test_who_stands_well_stays():
    assert stand((1.6, 0.0), (0.0, 0.0, 0.0)) == pytest.approx([0.0, 0.0], abs=0.1)


def test_who_stands_too_near_steps_back():
    found = stand((0.5, 0.0), (0.0, 0.0, 0.0))
    assert 1.3 < np.hypot(*(found - [0.5, 0.0])) <= 1.8


def test_a_strip_of_ground_between_the_places_compared_is_ground():
    occupied, reachable = room()
    strip = np.zeros_like(reachable)
    strip[81, 101:140] = reachable[81, 101:140]
    assert standpoint((3.0, 0.0), (-2.0, 0.0), 1.8, strip, occupied, FRAME) is not None


@pytest.mark.parametrize("side", [-1, 1])
def test_a_screen_before_the_place_is_walked_around(side):
    boxes = [(1.8, -0.8 * (side < 0) - 0.3, 1.9, 0.8 * (side > 0) + 0.3)]
    found = stand((2.5, 0.0), (-2.0, 0.0, 0.0), boxes)
    assert free_line(found, (2.5, 0.0), boxes) and np.sign(found[1]) == -side


def test_the_next_room_is_no_place_to_look_from():
    """A wall with a door at its far end between the robot's way and the place."""
    boxes = [(-1.0, -3.5, -0.9, 2.0)]
    found = stand((-0.3, -2.5), (-2.0, -2.5, 0.0), boxes)
    assert found[0] > -0.9


def test_on_a_table_it_is_seen_from_the_side_it_lies_on():
    table = (1.0, -1.0, 2.6, 1.0)
    found = stand((2.4, 0.0), (-2.0, 0.0, 0.0), [table])
    assert found[0] > 2.6 or abs(found[1]) > 1.0


def test_what_no_ground_comes_near_is_looked_at_from_the_nearest():
    found = stand((3.0, 0.0), (-2.0, 0.0, 0.0), [(0.0, -3.5, 4.9, 3.5)])
    assert -0.65 < found[0] < -0.15 and abs(found[1]) < 0.6


def test_without_ground_there_is_no_answer():
    occupied, reachable = room()
    assert standpoint((0.0, 0.0), (1.0, 0.0, 0.0), 1.8, reachable & False, occupied, FRAME) is None


WALL = (-1.0, -3.5, -0.9, 2.0)  # with a door at its far end


def before(place, seen_from, *boxes, near=0.9):
    occupied, reachable = room(*boxes)
    return stands_before(np.array(place), np.array(seen_from), near, reachable, occupied, FRAME)


def test_all_of_the_ground_before_a_place_is_on_the_side_it_was_seen_from():
    stands = before((-0.3, -1.0), (2.0, -1.0), WALL)
    assert len(stands) and (stands[:, 0] >= -0.3).all() and (np.hypot(*(stands - [-0.3, -1.0]).T) <= 0.9).all()


def test_the_other_side_of_a_wall_is_not_before_it_even_if_it_was_seen_along_the_wall():
    """Through the door, from the room that the robot is in: half of what is near lies on this side of the wall."""
    occupied, reachable = room(WALL)
    near_side = reachable & (np.arange(FRAME.shape[1]) < FRAME.to_cell([-1.0, 0.0])[1])  # what is known so far
    assert not len(stands_before(np.array([-0.3, 1.0]), np.array([-1.5, 2.6]), 0.9, near_side, occupied, FRAME))
    assert len(stands_before(np.array([-0.3, 1.0]), np.array([-1.5, 2.6]), 0.9, reachable, occupied, FRAME))


def test_what_stands_on_a_table_has_ground_before_it_as_long_as_the_table_is_small():
    assert len(before((0.0, 0.0), (2.0, 0.0), (-0.25, -0.25, 0.25, 0.25)))
    assert not len(before((0.0, 0.0), (2.0, 0.0), (-0.6, -0.6, 0.6, 0.6)))


@pytest.mark.parametrize("away", [0.05, 0.15, 0.25])
def test_a_thing_close_to_a_wall_is_not_stood_before_in_the_next_room(away):
    """Seen along the wall, and nothing tells the last bit of the wall from what the thing stands on."""
    place = np.array([-0.9 + away, -1.0])
    stands = before(place, place + [0.1, 2.0], WALL)
    assert len(stands) and (stands[:, 0] > -0.9).all()
