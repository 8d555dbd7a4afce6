"""``vlpg bench record FILE``: makes a recording for the other benchmarks, by mapping and searching a simulated home."""

import argparse
from pathlib import Path

from edge.bench.recording import write
from edge.memory.store import Vlpg
from edge.missions.find_object import FindObject
from edge.missions.map_home import MapHome
from edge.perception.encoder import Encoder
from edge.perception.prompts import Target, contrast
from edge.robot import Robot
from firmware_sim.home import load_home
from firmware_sim.house import HouseError
from firmware_sim.seed import seed
from firmware_sim.world import World
from models.manifest import DEFAULT, ModelError

HOME, OBJECTS = "apartment", ("plant", "radiator")


def record(path: Path, home: str, objects, model: str = DEFAULT, seed: int = 0) -> None:
    """Tour ``home``, then look for each of ``objects``, and write what was observed on the way.

    Raises HouseError and ModelError for names that do not exist, ValueError for an object without one.
    """
    world, encoder = World(load_home(home), seed), Encoder.load(model)
    targets = {name: Target.of(name, encoder) for name in objects}
    observations, questions = [world.step(None)], []
    with Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim) as memory:
        robot = Robot(encoder, memory, world.config.camera_model)
        mission = MapHome(robot)
        for name in (None, *objects):
            if name is not None:
                questions.append((len(observations) - 1, name))
                mission = FindObject(robot, targets[name], search_unknown=True)
            while not mission.done:
                observations.append(world.step(mission.step(observations[-1])))
    prompts = {prompt: encoder.encode_text([prompt])[0] for name in objects for prompt in contrast(name)}
    write(path, observations[:-1], questions, prompts)


def main(arguments: list[str] | None = None) -> None:
    """``vlpg bench record``."""
    parser = argparse.ArgumentParser(prog="vlpg bench record", description=__doc__.split(": ", 1)[1])
    parser.add_argument("file", type=Path, metavar="FILE", help="where to write it (.rec)")
    parser.add_argument("--home", default=HOME, help="a name, a file or generated:SEED (default: %(default)s)")
    parser.add_argument("--objects", nargs="+", default=OBJECTS, help="what to look for (default: %(default)s)")
    parser.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    parser.add_argument("--seed", type=seed, default=0, help="of all noise (default: %(default)s)")
    options = parser.parse_args(arguments)
    if not options.file.parent.is_dir():
        parser.error(f"there is no folder {options.file.parent} to write {options.file.name} into")
    try:
        record(options.file, options.home, options.objects, options.model, options.seed)
    except (HouseError, ModelError, OSError, ValueError) as error:
        parser.exit(2, f"vlpg bench record: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "")
    print(f"{options.file}: {options.file.stat().st_size / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
