"""What the emulated robot does: ``python3 there.py FOLDER``. Imports only what a bundle brings.

It encodes the reference pictures, searches the store that was made here and writes one of its own, and lives through
the recorded mission. What came of it is written to FOLDER/there.npz, for ``here.py`` to compare.
"""

import shutil
import sys
from pathlib import Path

import cv2
import numpy as np

from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg
from edge.missions.find_object import FindObject
from edge.observation import Observation
from edge.perception.encoder import Encoder
from edge.perception.prompts import Target
from edge.robot import Robot
from models.manifest import resolve

sys.path.insert(0, str(Path(__file__).parent))  # recording.py lies beside this file, outside of any package

from recording import read  # noqa: E402

HITS = 20


def vectors(encoder: Encoder) -> np.ndarray:
    """``(P, R, D)`` of the model's reference pictures."""
    with np.load(resolve() / "reference.npz") as known:
        parts = np.split(known["jpegs"], np.cumsum(known["lengths"])[:-1])
    pictures = [cv2.imdecode(part, cv2.IMREAD_COLOR)[..., ::-1] for part in parts]
    return np.stack([encoder.encode_image(rgb).vectors for rgb in pictures])


def found_in(memory: Vlpg, target: Target) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and scores of the store's best hits."""
    hits = memory.search(target.direction, HITS)
    return hits.ids, hits.scores


def awake(encoder: Encoder, memory: Vlpg, start: np.ndarray, first: Observation) -> Robot:
    """A robot that knows the home of ``memory``, and by its ``first`` observation is at ``start (3,)`` in it."""
    robot = Robot(encoder, memory)
    robot.grid = OccupancyGrid.from_bytes(memory.load_map())
    robot.localizer.move(first.odom, start)
    robot.perceive(first)
    return robot


def relive(folder: Path, encoder: Encoder, noun: str) -> dict[str, np.ndarray]:
    """Let the recorded observations happen to a robot that knows the home; what it did and believed."""
    shutil.copy(folder / "home.vlpg", folder / "relived.vlpg")
    with Vlpg.open(folder / "relived.vlpg", encoder.name, encoder.digest, encoder.dim) as memory:
        first, *others = read(folder / "mission.npz")
        robot = awake(encoder, memory, np.load(folder / "start.npy"), first)
        mission = FindObject(robot, Target.of(noun, encoder), search_unknown=True)
        commands, poses = [], []
        for observation in others:
            twist = mission.step(observation)
            commands.append((twist.v, twist.omega))
            poses.append(robot.pose)
    outcome = mission.outcome
    seen = outcome and outcome.claim and outcome.claim.sighting
    return {
        "commands": np.array(commands),
        "poses": np.array(poses),
        "status": np.array(outcome.status if outcome else "under way"),
        "claimed": np.array(seen.position if seen else [np.nan, np.nan]),
    }


def everything(folder: Path, noun: str) -> dict[str, np.ndarray]:
    """All that is compared."""
    encoder = Encoder.load()
    target = Target.of(noun, encoder)
    results = {"vectors": vectors(encoder), "direction": target.direction}
    with Vlpg.open(folder / "home.vlpg", encoder.name, encoder.digest, encoder.dim) as memory:
        results["ids"], results["scores"] = found_in(memory, target)
    return results | relive(folder, encoder, noun)


if __name__ == "__main__":
    where = Path(sys.argv[1])
    np.savez(where / "there.npz", **everything(where, (where / "noun.txt").read_text()))
