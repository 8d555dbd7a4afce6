"""Which things in a house do someone's words mean, and what to ask for when nobody says."""

from firmware_sim.house import House, HouseObject

ASKED = 6  # objects of a demo that is told nothing
HIGHEST = 1.6  # m; what hangs higher is above the camera's picture
SMALLEST = 0.3  # m, of the longest side; smaller things need to be named to be asked for

# Spread over the rooms, so that the robot must cross the home. In the apartment, everyday nouns that the shipped
# encoder knows well, some of which fit several things; `vlpg eval find` tells how it does with each thing's name.
DEFAULTS = {
    "apartment": ["tv", "chair", "plant", "toilet", "radiator"],
    "cottage": ["grand piano", "teddy bear", "large fridge", "desk lamp", "barrel", "winchester sofa"],
    "bungalow": ["pool table", "teddy bear", "fire extinguisher", "sofa", "refrigerator", "white board"],
}


def named(house: House, words: str) -> list[HouseObject]:
    """Everything that ``words`` can mean: "the red couch" is a Couch, "sofa" a Corner sofa or what is tagged so.

    The last word says what a thing is: a desk lamp is a lamp and no desk. The more telling name wins: where there is a
    Baby bed, the baby bed is no other bed.
    """
    words = " ".join(words.lower().split())
    for article in ("the ", "a ", "an ", "my "):
        words = words.removeprefix(article)
    if not words:
        return []
    told = {thing.id: _told(words, thing) for thing in house.objects.values()}
    most = max(told.values(), default=0)
    return [thing for thing in house.objects.values() if most and told[thing.id] == most]


def _told(words: str, thing: HouseObject) -> float:
    """How many characters of ``words`` the name of ``thing`` accounts for, from the last word on.

    A tag accounts for all of them, but comes after a name: where there is a TV, the cabinet tagged so is none.
    """
    name = thing.model.name.lower()
    if f" {name}".endswith(f" {words}"):
        return len(words)
    if words in (tag.lower() for tag in thing.model.tags):
        return len(words) - 0.5
    return len(name) if words.endswith(f" {name}") else 0


def default_objects(house: House) -> list[str]:
    """What to ask for: a chosen list for the homes that come along, else the largest things, a room at a time."""
    if house.name in DEFAULTS:
        return DEFAULTS[house.name]
    rooms: dict[str, list[HouseObject]] = {}
    for thing in sorted(house.objects.values(), key=lambda thing: -max(thing.model.size)):
        if thing.elevation < HIGHEST and max(thing.model.size) >= SMALLEST:
            room = house.room_at(thing.x, thing.y)
            rooms.setdefault(room.name if room else "", []).append(thing)
    chosen: dict[str, None] = {}  # a dict keeps the order and each noun once
    for rank in range(max(map(len, rooms.values()), default=0)):
        for things in rooms.values():
            if rank < len(things) and len(chosen) < ASKED:
                chosen.setdefault(things[rank].model.name.lower())
    return list(chosen)
