"""A home as people name it on the command line."""

from firmware_sim.house import House, HouseError

GENERATED = "generated:"


def load_home(home: str) -> House:
    """The home with this name ("apartment"), in this file ("my/house.json"), or from this seed ("generated:5").

    Raises HouseError, with one sentence, when there is no such home or it is an impossible one.
    """
    if not home.startswith(GENERATED):
        return House.load(home)
    seed = home.removeprefix(GENERATED)
    if not seed.isdecimal():
        raise HouseError(f"{home} has no seed; write {GENERATED}5, with any number from 0 on")
    from firmware_sim.generator import generate  # late: other homes need none of it

    return generate(int(seed))
