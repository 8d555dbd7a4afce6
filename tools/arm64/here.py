"""The side of this machine: ``python -m tools.arm64.here prepare|compare FOLDER``; see tools/arm64_check.sh.

``prepare`` records a tour of a small home and a search in it, with the shipped encoder, and does here what ``there.py``
is to do on ARM. ``compare`` reads what it did. Exit code 1: it did something else.
"""

import argparse
from pathlib import Path

import numpy as np

from edge.memory.store import Vlpg
from edge.perception.encoder import Encoder
from tools.arm64 import there
from tools.arm64.there import UNDER_WAY
from tools.bench.record import record

HOME, NOUN = str(Path(__file__).parent / "flat.json"), "plant"
ALIKE = 0.997, 0.98  # cosine of int8 embeddings between processors, median and least; each is that far from float32
NEAR = 0.05, np.radians(2.0)  # m, rad between the poses believed
APART = 0.3  # m between the places where the object is seen in the last picture
TWIST = 0.1, 0.2  # m/s, rad/s between commands, in the median


def prepare(folder: Path, home: str = HOME, noun: str = NOUN) -> None:
    """Write the recording and what this machine makes of it into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    record(folder / "mission.rec", home, [noun])
    np.savez(folder / "here.npz", **there.everything(folder, folder / "home.vlpg"))


def compare(folder: Path) -> list[tuple[str, str, bool]]:
    """What was looked at, how it differs, and whether that is little enough."""
    with np.load(folder / "here.npz") as ours, np.load(folder / "there.npz") as theirs:
        cosines = (ours["vectors"] * theirs["vectors"]).sum(-1)
        commands = np.median(np.abs(ours["commands"] - theirs["commands"]), axis=0)
        offsets = ours["poses"] - theirs["poses"]
        away = float(np.hypot(*offsets[:, :2].T).max())
        turned = float(np.abs(np.arctan2(np.sin(offsets[:, 2]), np.cos(offsets[:, 2]))).max())
        text = _cosine(ours["direction"], theirs["direction"])
        same = float((ours["ids"] == theirs["ids"]).mean())
        statuses = str(ours["status"]), str(theirs["status"])
        nodes = _nodes(folder / "there.vlpg")
        apart = float(np.hypot(*(ours["seen"] - theirs["seen"])))
        alike = float(np.median(cosines)), float(cosines.min())
        return [
            ("int8 picture vectors", "cosine {:.4f}, least {:.4f}".format(*alike), all(np.greater(alike, ALIKE))),
            ("int8 text direction", f"cosine {text:.4f}", text > ALIKE[0]),
            ("hits in a store made here", f"{same:.0%} the same", same >= 0.9),
            ("a store written there", f"{nodes} nodes are read here", nodes > 0),
            ("poses believed", f"at most {away:.3f} m, {np.degrees(turned):.2f}°", away < NEAR[0] and turned < NEAR[1]),
            ("commands", f"median {commands[0]:.3f} m/s, {commands[1]:.3f} rad/s", bool((commands <= TWIST).all())),
            ("the object in the last picture", f"{apart:.2f} m apart", apart <= APART),
            # Who is a little less sure looks on, and the recording has ended.
            (
                "the search's end",
                f"{statuses[0]} here, {statuses[1]} there",
                statuses[0] == statuses[1] or UNDER_WAY in statuses,
            ),
        ]


def _nodes(store: Path) -> int:
    encoder = Encoder.load(text=False)
    with Vlpg.open(store, encoder.name, encoder.digest, encoder.dim) as memory:
        return len(memory)


def _cosine(a, b) -> float:
    return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["prepare", "compare"])
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    if options.what == "prepare":
        prepare(options.folder)
        return
    rows = compare(options.folder)
    for subject, found, good in rows:
        print(f"{subject:28} {found:45} {'ok' if good else 'DIFFERS'}")
    raise SystemExit(0 if all(good for *_, good in rows) else 1)


if __name__ == "__main__":
    main()
