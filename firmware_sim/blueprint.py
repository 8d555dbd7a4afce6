"""Floor plans drawn by chance: a rectangle split again and again into rooms, with doors that join them all."""

from dataclasses import dataclass

import numpy as np

from firmware_sim.floor_plan import Door, Room, Wall


@dataclass(frozen=True)
class BlueprintConfig:
    """Sizes of an ordinary flat."""

    width: tuple[float, float] = (8.0, 11.0)  # m
    height: tuple[float, float] = (6.6, 9.0)  # m
    rooms: tuple[int, int] = (5, 7)
    shortest_side: float = 2.1  # m; a bathroom
    door_width: float = 0.9  # m
    door_margin: float = 0.25  # m from a door to the nearest corner
    extra_door: float = 0.35  # chance of a door beyond those that join the rooms: homes have loops


@dataclass(frozen=True)
class _Box:
    """An axis-parallel rectangle between two corners [m]."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def sides(self) -> tuple[float, float]:
        return self.x1 - self.x0, self.y1 - self.y0

    @property
    def area(self) -> float:
        return self.sides[0] * self.sides[1]

    def border_with(self, other):
        """The common side as two end points, or None."""
        low = max(self.x0, other.x0), max(self.y0, other.y0)
        high = min(self.x1, other.x1), min(self.y1, other.y1)
        if (low[0] == high[0] and high[1] > low[1]) or (low[1] == high[1] and high[0] > low[0]):
            return low, high
        return None


# Floors by category, wood elsewhere, and pastel wall colours.
FLOORS = {"Bathroom": "tiles", "Kitchen": "tiles", "Bedroom": "carpet", "Hall": "stone"}
WALL_COLORS = [
    (232, 224, 206), (240, 236, 204), (205, 216, 232), (203, 228, 222), (244, 222, 204),
    (214, 222, 206), (230, 212, 214), (224, 224, 224), (226, 214, 232), (238, 230, 220),
]  # fmt: skip


def draw(rng: np.random.Generator, config: BlueprintConfig) -> tuple[list[Room], list[Wall], list[Door]]:
    """Rooms, walls and doors of one home; all coordinates are multiples of 0.05 m, lower-left corner (0, 0).

    Binary space partition: the largest room that still can be is split across its longer side. The largest room in the
    end is the living room, the smallest the bathroom. The bathroom has one door.
    """
    width, height = (_snap(rng.uniform(*limits)) for limits in (config.width, config.height))
    boxes = [_Box(0.0, 0.0, width, height)]
    wanted = int(rng.integers(config.rooms[0], config.rooms[1] + 1))
    while len(boxes) < wanted:
        splittable = [box for box in boxes if max(box.sides) >= 2 * config.shortest_side]
        if not splittable:
            break
        largest = max(splittable, key=lambda box: box.area)
        boxes.remove(largest)
        boxes += _split(rng, largest, config.shortest_side)
    boxes.sort(key=lambda box: -box.area)
    borders = {
        (i, j): border
        for i in range(len(boxes))
        for j in range(i + 1, len(boxes))
        if (border := boxes[i].border_with(boxes[j])) is not None
    }
    walls = [
        Wall((0.0, 0.0), (width, 0.0)),
        Wall((width, 0.0), (width, height)),
        Wall((width, height), (0.0, height)),
        Wall((0.0, height), (0.0, 0.0)),
    ]
    doors = []
    open_borders = _choose_doors(rng, borders, len(boxes), config)
    for pair, (low, high) in borders.items():
        if pair not in open_borders:
            walls.append(Wall(low, high))
            continue
        door = _place_door(rng, low, high, config)
        doors.append(door)
        walls += [Wall(low, door.a), Wall(door.b, high)]
    return _name_rooms(rng, boxes), walls, doors


def _snap(value) -> float:
    return round(round(float(value) / 0.05) * 0.05, 2)


def _split(rng, box, shortest):
    along_x = box.sides[0] >= box.sides[1]
    low, high = (box.x0, box.x1) if along_x else (box.y0, box.y1)
    margin = max(shortest, 0.36 * (high - low))
    cut = _snap(rng.uniform(low + margin, high - margin))
    if along_x:
        return [_Box(box.x0, box.y0, cut, box.y1), _Box(cut, box.y0, box.x1, box.y1)]
    return [_Box(box.x0, box.y0, box.x1, cut), _Box(box.x0, cut, box.x1, box.y1)]


def _choose_doors(rng, borders, count, config):
    """Pairs of rooms with a door between: a random spanning tree (Kruskal), and now and then one more.

    The bathroom, the smallest and so the last room, is joined last, hence by one door; no one walks through it.
    """
    needed = config.door_width + 2 * config.door_margin
    wide = [pair for pair, (low, high) in borders.items() if max(high[0] - low[0], high[1] - low[1]) >= needed]
    order = [wide[i] for i in rng.permutation(len(wide))]
    bathroom = count - 1
    order.sort(key=lambda pair: bathroom in pair)
    group = list(range(count))
    chosen = []
    for i, j in order:
        joins = group[i] != group[j]
        if joins or (bathroom not in (i, j) and rng.random() < config.extra_door):
            chosen.append((i, j))
            group = [group[i] if g == group[j] else g for g in group]
    return set(chosen)


def _place_door(rng, low, high, config):
    """A door near one end of the border, so that a long piece of wall stays free for furniture."""
    axis = 0 if high[0] > low[0] else 1
    first = low[axis] + config.door_margin
    last = high[axis] - config.door_margin - config.door_width
    share = rng.beta(0.6, 0.6)
    start = min(max(_snap(first + share * (last - first)), low[axis]), high[axis] - config.door_width)
    a, b = list(low), list(low)
    a[axis], b[axis] = round(start, 2), round(start + config.door_width, 2)
    return Door(tuple(a), tuple(b))


def _name_rooms(rng, boxes):
    """Boxes from large to small become rooms: living room, then kitchen and bedrooms, ... and last the bathroom."""
    middle = ["kitchen", "bedroom", "office", "child's room", "hall"][: len(boxes) - 2]
    middle[:2] = [middle[i] for i in rng.permutation(2)]
    names = ["living room", *middle, "bathroom"]
    categories = {
        "living room": "Living room", "kitchen": "Kitchen", "bedroom": "Bedroom", "child's room": "Bedroom",
        "office": "Office", "hall": "Hall", "bathroom": "Bathroom",
    }  # fmt: skip
    colors = rng.permutation(len(WALL_COLORS))
    rooms = []
    for index, (box, name) in enumerate(zip(boxes, names)):
        category = categories[name]
        polygon = [(box.x0, box.y0), (box.x1, box.y0), (box.x1, box.y1), (box.x0, box.y1)]
        rooms.append(Room(name, category, polygon, FLOORS.get(category, "wood"), WALL_COLORS[colors[index]]))
    return rooms
