"""A furnished house: the floor plan and the things in it, loaded from JSON and changeable while a robot drives about.

House frame = map frame of the ground truth: x right, y up on the plan, metres. A model's front faces -y at yaw 0, so
yaw 0 puts its back against a northern wall, pi against a southern, -pi/2 against an eastern, pi/2 against a western.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import numpy as np

from edge.pose import compose, transform
from firmware_sim.floor_plan import Door, FloorPlan, Point, Room, Wall
from firmware_sim.placement import HouseError, check_house, check_object

if TYPE_CHECKING:
    from collections.abc import Mapping

    from firmware_sim.furniture import FurnitureModel

HOMES = Path(__file__).parent / "homes"
FARTHEST = 1000.0  # m (and rad) from the origin; more is a slip of the pen
Id = Annotated[str, msgspec.Meta(pattern=r"^\S+\Z")]


class ObjectEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An object as the file states it; ``on`` takes the height from the thing below, ``elevation`` states it."""

    id: Id
    model: Id
    position: Point  # m
    yaw: float = 0.0  # rad
    on: Id | None = None
    elevation: float | None = None  # m


class HouseFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The whole JSON file."""

    name: str
    rooms: list[Room]
    walls: list[Wall]
    doors: list[Door]
    objects: list[ObjectEntry]
    start: tuple[float, float, float]  # x, y [m], theta [rad]: the dock
    wall_height: Annotated[float, msgspec.Meta(gt=0)] = 2.5  # m


@dataclass(frozen=True, slots=True)
class HouseObject:
    """A thing in the house: its model, where it stands, and what it stands on."""

    id: str
    model: "FurnitureModel"
    x: float  # m
    y: float  # m
    yaw: float  # rad
    elevation: float  # m, of its base above the floor
    on: str | None = None
    footprint: np.ndarray = field(init=False, repr=False, compare=False)  # (N, 2) m, convex, in the house frame

    def __post_init__(self):
        object.__setattr__(self, "footprint", transform(self.pose, self.model.footprint))

    @property
    def pose(self) -> np.ndarray:
        return np.array([self.x, self.y, self.yaw])

    @property
    def height_range(self) -> tuple[float, float]:
        """Lowest and highest point above the floor [m]."""
        return self.elevation, self.elevation + self.model.size[2]


class House:
    """Floor plan, objects by id, and a start pose. ``revision`` grows with every change, for caches to notice."""

    def __init__(self, file: HouseFile, furniture: "Mapping[str, FurnitureModel]"):
        """Checks everything; raises HouseError with one sentence that names the fault."""
        _check_finite(file)
        self.name, self.wall_height = file.name, file.wall_height
        try:
            self.plan = FloorPlan(file.rooms, file.walls, file.doors)
        except ValueError as error:
            raise HouseError(str(error)) from None
        self.start = np.array(file.start, float)
        self.revision = 0
        self.objects: dict[str, HouseObject] = {}
        self._furniture = furniture
        pending = {}
        for entry in file.objects:
            if entry.id in pending:
                raise HouseError(f"two objects are called '{entry.id}'; give each its own id")
            pending[entry.id] = entry
        for entry in _supporters_first(pending):
            self.objects[entry.id] = self._resolve(entry)
        self.objects = {entry.id: self.objects[entry.id] for entry in file.objects}
        check_house(self)

    @classmethod
    def load(cls, path, furniture=None) -> "House":
        """Read a house file, or one of the homes that come along by its bare name ("apartment").

        Raises HouseError when the file is missing, is not a house, or describes something impossible.
        """
        path = Path(path)
        if path.suffix != ".json":
            path = HOMES / f"{path}.json"
        try:
            content = path.read_bytes()
        except OSError as error:
            known = ", ".join(sorted(home.stem for home in HOMES.glob("*.json")))
            raise HouseError(f"cannot read {path} ({error.strerror}); the homes at hand are {known}") from None
        try:
            return cls(msgspec.json.decode(content, type=HouseFile), _or_pack(furniture))
        except (msgspec.DecodeError, HouseError) as error:
            raise HouseError(f"{path.name}: {error}") from None

    @classmethod
    def from_dict(cls, data: dict, furniture=None) -> "House":
        """The same from plain dicts and lists. ``furniture`` maps model ids to models; default: the pack."""
        try:
            return cls(msgspec.convert(data, HouseFile), _or_pack(furniture))
        except msgspec.ValidationError as error:
            raise HouseError(str(error)) from None

    def to_dict(self) -> dict:
        """What ``from_dict`` takes, as the house is now."""
        entries = []
        for thing in self.objects.values():
            elevation = None if thing.on is not None or thing.elevation == 0.0 else thing.elevation
            entries.append(ObjectEntry(thing.id, thing.model.id, (thing.x, thing.y), thing.yaw, thing.on, elevation))
        plan = self.plan
        file = HouseFile(
            self.name, plan.rooms, plan.walls, plan.doors, entries, tuple(self.start.tolist()), self.wall_height
        )
        return msgspec.to_builtins(file)

    @property
    def rooms(self) -> list[Room]:
        return self.plan.rooms

    @property
    def doors(self) -> list[Door]:
        return self.plan.doors

    @property
    def bounds(self) -> np.ndarray:
        """Lower-left and upper-right corner ``(2, 2)`` of all rooms [m]."""
        return self.plan.bounds

    def wall_segments(self) -> np.ndarray:
        """Faces ``(N, 2, 2)`` [m] of all walls and closed doors."""
        return self.plan.wall_segments

    def room_at(self, x: float, y: float) -> Room | None:
        return self.plan.room_at(x, y)

    def standing_on(self, object_id: str) -> list[HouseObject]:
        """The things that stand directly on an object."""
        return [thing for thing in self.objects.values() if thing.on == object_id]

    def add_object(self, object_id, model, x, y, yaw=0.0, on=None, elevation=None) -> HouseObject:
        """Put a new thing into the house. Raises HouseError, and changes nothing, where it cannot stand."""
        if object_id in self.objects:
            raise HouseError(f"two objects are called '{object_id}'; give each its own id")
        thing = self._resolve(ObjectEntry(object_id, model, (float(x), float(y)), float(yaw), on, elevation))
        self._change({object_id: thing})
        return thing

    def move_object(self, object_id, x, y, yaw=None, on=None, elevation=None) -> HouseObject:
        """Stand a thing elsewhere, on the floor unless ``on`` or ``elevation`` says otherwise.

        What stands on it goes along; ``yaw`` None keeps the heading. Raises HouseError, and changes nothing, where it
        cannot stand.
        """
        old = self._get(object_id)
        yaw = old.yaw if yaw is None else float(yaw)
        if on is not None and on in self._burden(object_id):
            raise HouseError(f"object '{object_id}' cannot stand on '{on}', which stands on it")
        new = self._resolve(ObjectEntry(object_id, old.model.id, (float(x), float(y)), yaw, on, elevation))
        changes = {object_id: new}
        for rider_id in self._burden(object_id)[1:]:
            rider = self.objects[rider_id]
            cos, sin = np.cos(old.yaw), np.sin(old.yaw)
            dx, dy = rider.x - old.x, rider.y - old.y
            offset = (cos * dx + sin * dy, -sin * dx + cos * dy, rider.yaw - old.yaw)
            px, py, ptheta = (float(value) for value in compose(new.pose, offset))
            lift = new.elevation - old.elevation
            changes[rider_id] = replace(rider, x=px, y=py, yaw=ptheta, elevation=rider.elevation + lift)
        self._change(changes)
        return new

    def set_door(self, number: int, open: bool) -> None:
        """Open or close the door of that ``number`` in ``doors``. Raises HouseError when there is none."""
        doors = list(self.doors)
        if not 0 <= number < len(doors):
            raise HouseError(f"{self.name} has {len(doors)} doors, and none of number {number}")
        doors[number] = msgspec.structs.replace(doors[number], open=open)
        self.plan = FloorPlan(self.rooms, self.plan.walls, doors)
        self.revision += 1

    def remove_object(self, object_id) -> None:
        """Take a thing away. Raises HouseError when something stands on it."""
        self._get(object_id)
        riders = self.standing_on(object_id)
        if riders:
            raise HouseError(f"object '{riders[0].id}' stands on '{object_id}'; remove it first")
        del self.objects[object_id]
        self.revision += 1

    def _get(self, object_id) -> HouseObject:
        if object_id not in self.objects:
            raise HouseError(f"there is no object '{object_id}' in {self.name}")
        return self.objects[object_id]

    def _burden(self, object_id) -> list[str]:
        """The object and all that stands on it, directly or not; supporters before what they carry."""
        burden = [object_id]
        for supporter in burden:
            burden += [thing.id for thing in self.standing_on(supporter)]
        return burden

    def _change(self, changes: dict[str, HouseObject]) -> None:
        before = self.objects
        self.objects = before | changes
        try:
            for thing in changes.values():
                check_object(self, thing)
        except HouseError:
            self.objects = before
            raise
        self.revision += 1

    def _resolve(self, entry: ObjectEntry) -> HouseObject:
        """The object of a file entry; what it stands on must already be in the house."""
        if entry.model not in self._furniture:
            raise HouseError(f"object '{entry.id}' has the unknown model '{entry.model}'")
        elevation = entry.elevation or 0.0
        if entry.on is not None:
            if entry.elevation is not None:
                raise HouseError(f"object '{entry.id}' has both 'on' and 'elevation'; keep one")
            supporter = self.objects.get(entry.on)
            if supporter is None:
                raise HouseError(f"object '{entry.id}' stands on '{entry.on}', which does not exist")
            if supporter.model.top is None:
                raise HouseError(f"object '{entry.id}' stands on '{entry.on}', which has no top to stand on")
            elevation = supporter.elevation + supporter.model.top
        x, y = entry.position
        return HouseObject(entry.id, self._furniture[entry.model], x, y, entry.yaw, elevation, entry.on)


def _supporters_first(entries: dict[str, ObjectEntry]) -> list[ObjectEntry]:
    order: dict[str, ObjectEntry] = {}
    for entry in entries.values():
        chain = []
        while entry is not None and entry.id not in order:
            if entry in chain:
                raise HouseError(f"object '{entry.id}' stands, by way of others, on itself")
            chain.append(entry)
            entry = entries.get(entry.on) if entry.on is not None else None
        order |= {link.id: link for link in reversed(chain)}
    return list(order.values())


def _check_finite(file: HouseFile) -> None:
    """Raises HouseError for numbers that no house has: JSON can hold 1e300, and dicts can hold NaN."""
    for kind in ("rooms", "walls", "doors", "objects"):
        for index, entry in enumerate(getattr(file, kind)):
            if not _are_sane(msgspec.to_builtins(entry)):
                raise HouseError(f"{kind}[{index}] has a coordinate beyond {FARTHEST:.0f} m")
    if not _are_sane([file.wall_height, list(file.start)]):
        raise HouseError(f"the start or the wall height is beyond {FARTHEST:.0f} m")


def _are_sane(value) -> bool:
    """Whether all numbers in nested dicts and sequences are within +-FARTHEST; NaN is not."""
    if isinstance(value, dict):
        return all(map(_are_sane, value.values()))
    if isinstance(value, list | tuple):
        return all(map(_are_sane, value))
    return not isinstance(value, float) or abs(value) <= FARTHEST


def _or_pack(furniture):
    return pack() if furniture is None else furniture


@lru_cache(maxsize=1)
def pack() -> "Mapping[str, FurnitureModel]":
    """The furniture that comes along, read once."""
    from firmware_sim.furniture import Furniture  # late: who brings furniture of his own does without the sprites' code

    return Furniture.load()
