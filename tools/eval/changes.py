"""What happens to a home while its robot is switched off: things are moved, taken away and brought in."""

from collections import Counter
from dataclasses import dataclass, field
from math import hypot, pi

import numpy as np

from firmware_sim.free_space import FreeSpace
from firmware_sim.house import House, HouseError, HouseObject
from firmware_sim.house import pack as furniture_pack
from firmware_sim.placement import ROBOT_RADIUS, what_blocks
from tools.eval.disturbance import TRIES, Impossible
from tools.eval.tour import HIGHEST

FAR = 2.0  # m, at least, that a thing is moved
PORTABLE = 1.2  # m, of its longer side: what people carry about
HEIGHTS = 0.3, 1.6  # m, of what is brought in: large enough to be told apart, and all of it in the picture
DOORWAY = 0.8  # m around a door's middle that stays clear
IN_REACH = 1.5  # m, at most, from where the robot can go
ROOM_LEFT = 0.9  # share of the floor in reach that a change must leave so


@dataclass
class Household:
    """A home that changes. Only things that are the only ones of their name do, so that the truth is plain."""

    house: House
    rng: np.random.Generator
    moved: set[str] = field(default_factory=set)  # nouns
    removed: set[str] = field(default_factory=set)
    added: set[str] = field(default_factory=set)

    def newcomers(self, count: int) -> list[str]:
        """Ids of ``count`` models, drawn by lot, whose names nothing in the home has."""
        taken, models = set(_names(self.house)), {}
        for model in furniture_pack().values():
            if model.elevation is None and HEIGHTS[0] < model.size[2] < HEIGHTS[1] and max(model.size[:2]) < PORTABLE:
                models.setdefault(model.name.lower(), model.id)
        names = sorted(models.keys() - taken)
        return [models[name] for name in self.rng.permutation(names)[:count].tolist()]

    def change(self, arriving: list[str]) -> set[str]:
        """Bring in the models with these ids, and move and take away as many things that nothing happened to yet.

        Returns the nouns of what was moved or taken away. What nothing has room for stays as it is.
        """
        names, before = _names(self.house), self.moved | self.removed
        touched = self.moved | self.added
        movable = [
            thing.id
            for thing in self.house.objects.values()
            if names[thing.model.name.lower()] == 1
            and thing.model.name.lower() not in touched
            and self._is_portable(thing)
        ]
        movable = self.rng.permutation(movable).tolist()
        for chosen, act in ((self.moved, self._move), (self.removed, self._remove)):
            goal = len(chosen) + len(arriving)
            while len(chosen) < goal and movable:
                noun = self.house.objects[movable[-1]].model.name.lower()
                try:
                    act(movable.pop())
                except Impossible:
                    continue
                chosen.add(noun)
        for model in arriving:
            try:
                self._add(model)
            except Impossible:
                continue
            self.added.add(furniture_pack()[model].name.lower())
        return (self.moved | self.removed) - before

    def _is_portable(self, thing: HouseObject) -> bool:
        model = thing.model
        stands = model.elevation is None and thing.elevation < HIGHEST
        return stands and max(model.size[:2]) < PORTABLE and not self.house.standing_on(thing.id)

    def _remove(self, thing_id: str) -> None:
        self.house.remove_object(thing_id)

    def _move(self, thing_id: str) -> None:
        old = self.house.objects[thing_id]

        def undo():
            height = None if old.on else old.elevation
            self.house.move_object(thing_id, old.x, old.y, old.yaw, old.on, height)

        self._stand(
            lambda x, y, yaw: hypot(x - old.x, y - old.y) > FAR and self.house.move_object(thing_id, x, y, yaw), undo
        )

    def _add(self, model: str) -> None:
        name = f"new-{model}"
        self._stand(
            lambda x, y, yaw: self.house.add_object(name, model, x, y, yaw), lambda: self.house.remove_object(name)
        )

    def _stand(self, put, undo) -> None:
        """``put`` something where the robot can look at it and still goes everywhere. Raises Impossible."""
        low, high = self.house.bounds
        before = FreeSpace(self.house).reachable(ROBOT_RADIUS).sum()
        for _ in range(TRIES):
            (x, y), yaw = self.rng.uniform(low, high), self.rng.uniform(-pi, pi)
            try:
                stands = self._is_clear(x, y) and put(x, y, yaw)
            except HouseError:
                continue
            if not stands:
                continue
            space = FreeSpace(self.house)
            reachable = space.reachable(ROBOT_RADIUS)
            away = space.frame.to_world(*np.nonzero(reachable)) - (x, y)
            near = np.hypot(*away.T).min(initial=np.inf) < IN_REACH
            if near and reachable.sum() > ROOM_LEFT * before and not what_blocks(self.house, self.house.start[:2], 0.3):
                return
            undo()
        raise Impossible(f"nothing more fits into {self.house.name}")

    def _is_clear(self, x: float, y: float) -> bool:
        return all(hypot(*((np.array(door.a) + door.b) / 2 - (x, y))) > DOORWAY for door in self.house.doors)


def _names(house: House) -> Counter:
    return Counter(thing.model.name.lower() for thing in house.objects.values())
