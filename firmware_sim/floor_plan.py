"""The shell of a house: rooms, walls and doors, and the wall faces that camera, lidar and physics see.

Room polygons follow the centre lines of the walls around them, so rooms tile the floor and every doorway lies in a
room or on the line between two.
"""

from typing import Annotated, Literal

import msgspec
import numpy as np

from firmware_sim.polygons import band, contains, edges, penetration

WALL_THICKNESS = 0.10  # m; a light partition wall
TOUCHING = 1e-3  # m; two walls meet when the end of one is this near to the centre line of the other

Point = tuple[float, float]


class Room(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One room: where its floor lies and what it looks like."""

    name: str
    category: str  # the furniture library's: Kitchen, Bedroom, Bathroom, "Living room", Office, ...
    polygon: Annotated[list[Point], msgspec.Meta(min_length=3)]  # m
    floor: Literal["wood", "tiles", "carpet", "stone"] = "wood"
    wall_color: tuple[int, int, int] = (225, 220, 210)  # RGB


class Wall(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A straight wall by its centre line; a doorway is a gap between two walls."""

    a: Point
    b: Point


class Door(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The doorway between the wall ends a and b; closed, it is a wall."""

    a: Point
    b: Point
    open: bool = True


class FloorPlan:
    """Rooms, walls and doors, with the walls' solid bodies worked out once."""

    def __init__(self, rooms: list[Room], walls: list[Wall], doors: list[Door]):
        self.rooms, self.walls, self.doors = rooms, walls, doors
        corners = np.array([corner for room in rooms for corner in room.polygon], float).reshape(-1, 2)
        self.bounds = np.stack([corners.min(0), corners.max(0)]) if len(corners) else np.zeros((2, 2))
        lines = [(np.array(wall.a), np.array(wall.b)) for wall in walls]
        lines += [(np.array(door.a), np.array(door.b)) for door in doors if not door.open]
        # A wall that ends on another one reaches half a thickness further, so that corners are closed; a hair less,
        # so that its end face disappears inside the other wall instead of lying flush with its far side.
        self.wall_bodies = [
            band(a, b, WALL_THICKNESS, self._reach(lines, i, a), self._reach(lines, i, b))
            for i, (a, b) in enumerate(lines)
        ]
        self.wall_segments = self._faces()

    @staticmethod
    def _reach(lines, i, end):
        for j, (a, b) in enumerate(lines):
            if j == i:
                continue
            along = b - a
            share = np.clip((end - a) @ along / (along @ along), 0.0, 1.0)
            if np.hypot(*(a + share * along - end)) < TOUCHING:
                return WALL_THICKNESS / 2 - TOUCHING
        return 0.0

    def _faces(self):
        """Faces ``(N, 2, 2)`` of the wall bodies, without those that lie wholly inside another wall."""
        faces = []
        for i, body in enumerate(self.wall_bodies):
            for face in edges(body):
                others = (other for j, other in enumerate(self.wall_bodies) if j != i)
                if not any(_covers(other, face) for other in others):
                    faces.append(face)
        return np.array(faces, float).reshape(-1, 2, 2)

    def room_at(self, x: float, y: float) -> Room | None:
        """The room whose polygon holds the point, or None."""
        for room in self.rooms:
            if contains(np.array(room.polygon), np.array([x, y])):
                return room
        return None

    def wall_overlap(self, footprint) -> float:
        """How deep [m] a convex ``footprint (N, 2)`` reaches into the walls; <= 0 when it is clear of them."""
        low, high = footprint.min(0), footprint.max(0)
        deepest = -np.inf
        for body in self.wall_bodies:
            if (body.min(0) < high).all() and (body.max(0) > low).all():
                deepest = max(deepest, penetration(footprint, body))
        return deepest


def _covers(body, face):
    """Whether a face lies inside a convex counter-clockwise body, within the hair of ``_reach``, not along a side."""
    sides = np.roll(body, -1, axis=0) - body
    normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1) / np.hypot(sides[:, 0], sides[:, 1])[:, None]
    outside = (normals[:, None, :] * (face[None, :, :] - body[:, None, :])).sum(-1)
    if (outside > 2 * TOUCHING).any():
        return False
    return bool((outside.mean(axis=1) < -1e-6).all())
