"""What the emulated robot does: ``python3 there.py FOLDER``. Imports only what a bundle brings.

It encodes the reference pictures, searches the store that was made here, lives through the recorded mission, and writes
a store of its own. What came of it is written to FOLDER/there.npz, for ``here.py`` to compare.
"""

import sys
from pathlib import Path

import cv2
import numpy as np

from edge.bench.recording import Recording
from edge.bench.replay import Replay
from edge.memory.store import Vlpg
from edge.missions.sighting import sight
from edge.perception.detection import Detector, DetectorConfig
from edge.perception.encoder import Encoder
from edge.robot import Robot
from models.manifest import resolve

HITS = 20
UNDER_WAY = "under way"  # a search that the recording's end cuts off


def vectors(encoder: Encoder) -> np.ndarray:
    """``(P, R, D)`` of the model's reference pictures."""
    with np.load(resolve() / "reference.npz") as known:
        parts = np.split(known["jpegs"], np.cumsum(known["lengths"])[:-1])
    pictures = [cv2.imdecode(part, cv2.IMREAD_COLOR)[..., ::-1] for part in parts]
    return np.stack([encoder.encode_image(rgb).vectors for rgb in pictures])


def relive(recording: Recording, encoder: Encoder, store: Path) -> dict[str, np.ndarray]:
    """Let the recorded observations happen to a robot with an empty ``store``; what it did, believed, saw last."""
    store.unlink(missing_ok=True)
    with Vlpg.open(store, encoder.name, encoder.digest, encoder.dim) as memory:
        robot = Robot(encoder, memory)
        replay = Replay(recording, robot)
        rows = [(twist.v, twist.omega, *robot.pose) for twist in replay.run()]
        (search,) = replay.searches.values()
        outcome, target = search.outcome, search.target
        seen = sight(robot, Detector(encoder, DetectorConfig(min_score=0.0)), target, robot.look_closely())
    return {
        "commands": np.array(rows)[:, :2],
        "poses": np.array(rows)[:, 2:],
        "status": np.array(outcome.status if outcome else UNDER_WAY),
        "seen": np.array(seen.position if seen else [np.nan, np.nan]),
        "direction": target.direction,
    }


def everything(folder: Path, store: Path) -> dict[str, np.ndarray]:
    """All that is compared. ``store`` is written; what is searched is the one that was made here."""
    encoder = Encoder.load()
    results = relive(Recording(folder / "mission.rec"), encoder, store) | {"vectors": vectors(encoder)}
    with Vlpg.open(folder / "home.vlpg", encoder.name, encoder.digest, encoder.dim) as memory:
        return results | {"ids": memory.search(results["direction"], HITS).ids}


if __name__ == "__main__":
    where = Path(sys.argv[1])
    np.savez(where / "there.npz", **everything(where, where / "there.vlpg"))
