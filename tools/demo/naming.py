"""Which things in a house do someone's words mean, and what to ask for when nobody says."""

from firmware_sim.house import House, HouseObject

ASKED = 6  # objects of a demo that is told nothing
HIGHEST = 1.6  # m; what hangs higher is above the camera's picture
SMALLEST = 0.3  # m, of the longest side; smaller things need to be named to be asked for

# Spread over the rooms, so that the robot must cross the home. In the apartment, things that the shipped encoder knows
# well; `vlpg eval find` tells how it does with all of them.
DEFAULTS = {
    "apartment": ["refrigerator", "tv", "toilet", "baby bed", "bidet"],
    "cottage": ["grand piano", "teddy bear", "large fridge", "desk lamp", "barrel", "winchester sofa"],
    "bungalow": ["pool table", "teddy bear", "fire extinguisher", "sofa", "refrigerator", "white board"],
}


def named(house: House, words: str) -> list[HouseObject]:
    """Everything that ``words`` can mean: "the red couch" is a Couch, "sofa" a Corner sofa or what is tagged so.

    The last word says what a thing is: a desk lamp is a lamp and no desk.
    """
    words = " ".join(words.lower().split())
    for article in ("the ", "a ", "an ", "my "):
        words = words.removeprefix(article)
    return [thing for thing in house.objects.values() if _means(words, thing)] if words else []


def _means(words: str, thing: HouseObject) -> bool:
    name = thing.model.name.lower()
    if words == name or words.endswith(f" {name}") or name.endswith(f" {words}"):
        return True
    return words in (tag.lower() for tag in thing.model.tags)


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
