"""``python -m tools.models.probe TOWER FOLDER``: one tower in a process of its own, to be timed and weighed.

It prints ``ready`` when the tower has run a few times, then answers each line on stdin, a number of passes, with a JSON
list of their durations [s]. It ends with its stdin.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

from edge.bench.subject import pin

WARM = 5  # passes before it is ready: the first ones allocate and touch the weights


def serve(run: Callable[[int], object]) -> None:
    """Answer as above, from one core; ``run(i)`` is one pass, the i-th."""
    pin()
    done = 0
    for _ in range(WARM):
        run(done := done + 1)
    print("ready", flush=True)
    for line in sys.stdin:
        times = []
        for _ in range(int(line)):
            started = time.perf_counter()
            run(done := done + 1)
            times.append(time.perf_counter() - started)
        print(json.dumps(times), flush=True)


def image(folder: Path) -> Callable[[int], object]:
    """The image graph alone, as the robot opens it, on a picture that is prepared already."""
    import numpy as np

    from edge.perception.session import open_session
    from models.manifest import Manifest

    manifest = Manifest.load(folder)
    session = open_session(manifest.folder / manifest.image.graph, frequent=True)
    shape = (1, 3, manifest.image.height, manifest.image.width)
    picture = np.random.default_rng(0).normal(size=shape).astype(np.float32)
    return lambda _: session.run(None, {"image": picture})


def encoder(folder: Path) -> Callable[[int], object]:
    """The image side as the robot has it: OpenCV, preprocessing from 320 x 240, the image graph."""
    import numpy as np

    from edge.perception.encoder import Encoder
    from models.manifest import Manifest

    loaded = Encoder(Manifest.load(folder), text=False)
    rgb = np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    return lambda _: loaded.encode_image(rgb)


def text(folder: Path) -> Callable[[int], object]:
    """Tokenizer and text graph on a prompt of the length of [V] Eq. 2's, a new one each time."""
    from edge.perception.text import TextTower
    from models.manifest import Manifest

    tower = TextTower(Manifest.load(folder))
    tower.open()
    return lambda i: tower.encode([f"A photo of teddy bear {i % 10}"])


TOWERS = {"image": image, "encoder": encoder, "text": text}


def main() -> None:
    from edge.process import give_back_large_blocks

    give_back_large_blocks()  # as the robot process does
    tower, folder = sys.argv[1:]
    serve(TOWERS[tower](Path(folder)))


if __name__ == "__main__":
    main()
