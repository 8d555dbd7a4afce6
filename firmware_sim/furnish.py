"""Puts furniture into the rooms of an empty house by recipe, so that nothing collides and the robot gets everywhere."""

from math import pi

import numpy as np

from edge.pose import transform
from firmware_sim.floor_plan import WALL_THICKNESS
from firmware_sim.free_space import FreeSpace
from firmware_sim.placement import ROBOT_RADIUS, HouseError, is_obstacle
from firmware_sim.polygons import band, distance_to_segments, edges, penetration
from firmware_sim.recipes import RECIPES, TOP_SPOTS, Piece

TRIES = 24  # places for a piece before it is left out
PASSAGE = ROBOT_RADIUS + 0.15  # m; radius of the free way that must stay between the rooms
DOOR_DEPTH = 0.7  # m kept free on either side of a doorway
START_CLEARANCE = 0.40  # m kept free around the dock
KEEP_FREE = 0.3  # share of a room's passable floor that furniture must leave


class Furnisher:
    """Adds things to one house. ``furniture`` maps model ids to models; what is not in it is left out."""

    def __init__(self, house, furniture, rng: np.random.Generator):
        self._house, self._furniture, self._rng = house, furniture, rng
        self._used: dict[str, int] = {}
        self._doorways = [band(door.a, door.b, 2 * DOOR_DEPTH) for door in house.doors]
        free = FreeSpace(house).reachable_area(PASSAGE)
        self._floor_wanted = {name: KEEP_FREE * area for name, area in free.items()}

    def furnish(self) -> None:
        """Furnish all rooms by the recipes that bear their names."""
        for room in self._house.rooms:
            for piece in RECIPES[room.name]:
                self._place(room, piece, None)

    def _place(self, room, piece: Piece, anchor) -> None:
        if self._rng.random() >= piece.chance:
            return
        known = [model for model in piece.models if model in self._furniture]
        # Things that the home does not have yet come first, so that a name means one thing.
        order = sorted(self._rng.permutation(known).tolist(), key=lambda model: self._used.get(model, 0))
        for model_id in order[:2]:
            thing = self._try_model(room, self._furniture[model_id], piece.place, anchor)
            if thing is not None:
                for companion in piece.companions:
                    self._place(room, companion, thing)
                return

    def _try_model(self, room, model, place, anchor):
        number = self._used.get(model.id, 0) + 1
        object_id = f"{model.id}-{number}"
        propose = getattr(self, f"_{place}")
        for _ in range(TRIES):
            x, y, yaw = propose(room, model, anchor)
            on = anchor.id if place == "on" else None
            elevation = model.elevation if on is None else None
            try:
                thing = self._house.add_object(object_id, model.id, x, y, yaw, on, elevation)
            except HouseError:
                continue
            if self._leaves_ways_free(room, thing):
                self._used[model.id] = number
                return thing
            self._house.remove_object(object_id)
        return None

    def _leaves_ways_free(self, room, thing) -> bool:
        if self._house.room_at(thing.x, thing.y) is not room:
            return False
        # Not even a clock may hang in a doorway: there is no wall.
        if thing.on is None and any(penetration(thing.footprint, doorway) > 0 for doorway in self._doorways):
            return False
        if not is_obstacle(thing):
            return True
        if distance_to_segments(self._house.start[:2], edges(thing.footprint)) < START_CLEARANCE:
            return False
        area = FreeSpace(self._house).reachable_area(PASSAGE)
        return all(area[name] >= wanted for name, wanted in self._floor_wanted.items())

    # Proposals: a pose (x, y, yaw) for a model; whether it can stand there is checked afterwards.

    def _wall(self, room, model, anchor):
        """Back against a wall of a rectangular room, a centimetre from it."""
        corners = np.array(room.polygon)
        side = int(self._rng.integers(len(corners)))
        a, b = corners[side], corners[(side + 1) % len(corners)]
        # Counter-clockwise corners: the wall's inner normal is to the left of a-b, and there the front looks.
        heading = np.arctan2(b[1] - a[1], b[0] - a[0])
        normal = np.array([-np.sin(heading), np.cos(heading)])
        reach = model.size[0] / 2 + WALL_THICKNESS / 2 + 0.02
        length = np.hypot(*(b - a))
        if length < 2 * reach:
            along = length / 2
        else:
            # Furniture likes corners: half of it stands in one.
            along = self._rng.choice([reach, length - reach, self._rng.uniform(reach, length - reach)])
        back = model.footprint[:, 1].max() + WALL_THICKNESS / 2 + 0.01
        x, y = a + along * np.array([np.cos(heading), np.sin(heading)]) + back * normal
        return x, y, _tidy(heading + pi)

    def _floor(self, room, model, anchor):
        low, high = np.min(room.polygon, axis=0) + 0.3, np.max(room.polygon, axis=0) - 0.3
        x, y = self._rng.uniform(low, high)
        return x, y, self._rng.uniform(-pi, pi)

    def _centre(self, room, model, anchor):
        low, high = np.min(room.polygon, axis=0), np.max(room.polygon, axis=0)
        x, y = (low + high) / 2 + self._rng.uniform(-0.25, 0.25, 2) * (high - low)
        return x, y, self._rng.choice([0.0, pi / 2])

    def _on(self, room, model, anchor):
        spot = TOP_SPOTS.get(anchor.model.id)
        if spot is None:
            spare = np.maximum(np.subtract(anchor.model.size[:2], model.size[:2]), 0.0) / 2 * 0.8
            spot = self._rng.uniform(-spare, spare)
        x, y = transform(anchor.pose, np.array([spot]))[0]
        return x, y, _tidy(anchor.yaw + self._rng.uniform(-0.3, 0.3))

    def _beside(self, room, model, anchor):
        step = (anchor.model.size[0] + model.size[0]) / 2 + 0.02
        side = self._rng.choice([-step, step])
        # Backs flush with one another.
        back = anchor.model.footprint[:, 1].max() - model.footprint[:, 1].max()
        x, y = transform(anchor.pose, np.array([[side, back]]))[0]
        return x, y, anchor.yaw

    def _before(self, room, model, anchor):
        away = (anchor.model.size[1] + model.size[1]) / 2 + self._rng.uniform(0.03, 0.25)
        x, y = transform(anchor.pose, np.array([[self._rng.uniform(-0.2, 0.2), -away]]))[0]
        return x, y, _tidy(anchor.yaw + pi + self._rng.uniform(-0.3, 0.3))

    def _around(self, room, model, anchor):
        # At quarter turn q it is at the right, back, left or front side; turned by q - 1 it looks at the anchor.
        quarter = int(self._rng.integers(4))
        away = (anchor.model.size[quarter % 2] + model.size[1]) / 2 + self._rng.uniform(0.0, 0.1)
        angle = quarter * pi / 2
        x, y = transform(anchor.pose, away * np.array([[np.cos(angle), np.sin(angle)]]))[0]
        return x, y, _tidy(anchor.yaw + angle - pi / 2 + self._rng.uniform(-0.15, 0.15))


def _tidy(angle) -> float:
    """The angle [rad] in [-pi, pi)."""
    return float((angle + pi) % (2 * pi) - pi)
