"""``vlpg bench``: the robot's own benchmarks, recordings for them, and what others would do in its place."""

import sys
from pathlib import Path

from edge.bench.__main__ import main as bench
from edge.process import cache_file
from models.manifest import Manifest, resolve
from tools.bench import boards, encoder, store

EPILOG = """\
vlpg bench record FILE         make a recording, of another home or other objects than the usual one
vlpg bench boards REPORT        an estimate, from what mission --json wrote, for boards where it was not measured
vlpg bench peers encoder       the image tower beside the same in float32
vlpg bench peers store         a question to the memory beside other vector searches
"""
PEERS = {"encoder": encoder.main, "store": store.main}


def usual_recording(model: str) -> Path:
    """The file of the recording that is used for ``model`` when none is named; it is made if it does not exist.

    Raises ModelError when there is no such model.
    """
    name = f"bench-{Manifest.load(resolve(model)).digest[:12]}.rec"
    file = cache_file(name) or Path(name)
    if not file.is_file():
        from tools.bench import record  # late: it needs the simulator

        print(f"recording a tour and searches in the {record.HOME}, once: {file}", file=sys.stderr)
        whole = file.with_suffix(".part")
        file.parent.mkdir(parents=True, exist_ok=True)
        record.record(whole, record.HOME, record.OBJECTS, model)
        whole.rename(file)
    return file


def main() -> None:
    match sys.argv[1:]:
        case ["record", *others]:
            from tools.bench import record

            record.main(others)
        case ["boards", *others]:
            boards.main(others)
        case ["peers", kind, *others] if kind in PEERS:
            PEERS[kind](others)
        case ["peers", *_]:
            sys.exit("vlpg bench peers: say whose: encoder or store")
        case arguments:
            bench(arguments, "vlpg bench", EPILOG, usual_recording)


if __name__ == "__main__":
    main()
