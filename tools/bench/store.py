"""``vlpg bench peers store``: speed of a question to the memory, on one thread, beside libraries for vector search.

Each searches the same vectors of 512 components for the 50 nearest, in a process of its own: numpy, faiss and usearch,
those that are installed. All are exact but usearch's graph. Ours rounds vectors to int8, as usearch is told to do, and
keeps poses and an SQLite database beside them.
"""

import argparse
import importlib.util
import json
from dataclasses import asdict
from pathlib import Path

from edge.bench.probe_process import ProbeFailed
from edge.bench.store import DIM, HITS, filled
from tools.bench import search
from tools.bench.peers import TURNS, Peer, measure, show

OURS = "int8, exact, the memory"
PEERS = {
    "float32, exact, numpy": ("numpy", "numpy"),
    "float32, exact, faiss": ("faiss", "faiss"),
    "int8, exact, usearch": ("usearch", "usearch"),
    "int8, approximate, usearch": ("usearch", "usearch-graph"),
}


def peers(count: int) -> tuple[dict[str, tuple[str, ...]], list[str]]:
    """Command of each search that can run here, ours first, and a sentence on each package that is not installed."""
    commands, missing = {OURS: ("tools.bench.search", "vlpg", str(count))}, {}
    for name, (package, kind) in PEERS.items():
        if importlib.util.find_spec(package):
            commands[name] = ("tools.bench.search", kind, str(count))
        else:
            missing[package] = f"{package} is left out: it is not installed (pip install '.[peers]')."
    return commands, list(missing.values())


def bytes_per_byte(count: int) -> float:
    """Bytes of RAM that the memory takes, poses included, for each byte of int8 embedding."""
    return filled(":memory:", count // search.REGIONS, search.REGIONS).nbytes / (count * DIM)


def main(arguments: list[str] | None = None) -> None:
    """``vlpg bench peers store``."""
    parser = argparse.ArgumentParser(prog="vlpg bench peers store", description=__doc__.split(": ", 1)[1])
    parser.add_argument("--vectors", default="2000,20000", help="how many, comma-separated (default: %(default)s)")
    parser.add_argument("--turns", type=int, default=TURNS, help="of timed searches (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    options = parser.parse_args(arguments)
    counts = options.vectors.split(",")
    if not all(count.isdecimal() and int(count) >= HITS for count in counts):
        parser.error(f"--vectors takes numbers of at least {HITS}, comma-separated, not {options.vectors!r}")
    if options.turns < 1:
        parser.error("--turns must be at least 1")
    results: dict[str, list[Peer]] = {}
    for count in counts:
        commands, missing = peers(int(count))
        try:
            results[count] = measure(commands, options.turns)
        except ProbeFailed as error:
            parser.exit(2, f"vlpg bench peers store: {error}\n")
        print(f"{count} vectors; the memory takes {bytes_per_byte(int(count)):.2f} bytes for each byte of them in int8")
        print(show(results[count]))
        others = [peer.ratio for peer in results[count][1:] if "exact" in peer.name]
        if others:
            print(f"ours takes {1 / min(others):.2f} times as long as the fastest other exact search")
        print()
    print("\n".join(missing))
    if options.json:
        found = {count: [asdict(peer) for peer in peers] for count, peers in results.items()}
        options.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
