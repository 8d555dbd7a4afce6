import numpy as np

from firmware_sim.floor_plan import Door, FloorPlan, Room, Wall
from firmware_sim.polygons import contains

ROOM = Room("hall", "Living room", [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])
LOOP = [Wall(a, b) for a, b in zip(ROOM.polygon, ROOM.polygon[1:] + ROOM.polygon[:1])]


def test_a_closed_loop_has_an_inner_and_an_outer_face_a_side():
    faces = FloorPlan([ROOM], LOOP, []).wall_segments
    assert len(faces) == 8
    middles = faces.mean(axis=1)
    offsets = np.minimum(np.abs(middles - 0.0), np.abs(middles - 4.0)).min(axis=1)
    np.testing.assert_allclose(offsets, 0.05, atol=1e-9)


def test_corners_are_closed():
    plan = FloorPlan([ROOM], LOOP, [])
    corner = np.array([-0.03, -0.03])
    assert any(contains(body, corner) for body in plan.wall_bodies)


def test_a_doorway_keeps_its_width_and_its_jambs():
    walls = [*LOOP, Wall((2.0, 0.0), (2.0, 1.55)), Wall((2.0, 2.45), (2.0, 4.0))]
    faces = FloorPlan([ROOM], walls, [Door((2.0, 1.55), (2.0, 2.45))]).wall_segments
    jambs = [face for face in faces if np.ptp(face[:, 1]) < 1e-9 and 1.0 < face[0, 1] < 3.0]
    np.testing.assert_allclose(sorted(face[0, 1] for face in jambs), [1.55, 2.45])


def test_a_closed_door_is_a_wall():
    walls = [*LOOP, Wall((2.0, 0.0), (2.0, 1.55)), Wall((2.0, 2.45), (2.0, 4.0))]
    footprint = np.array([[1.9, 1.9], [2.1, 1.9], [2.1, 2.1], [1.9, 2.1]])
    door = Door((2.0, 1.55), (2.0, 2.45))
    assert FloorPlan([ROOM], walls, [door]).wall_overlap(footprint) <= 0
    closed = Door(door.a, door.b, open=False)
    assert FloorPlan([ROOM], walls, [closed]).wall_overlap(footprint) > 0.05
