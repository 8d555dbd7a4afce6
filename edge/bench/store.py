"""``python -m edge.bench.store``: the memory of a home at its limit, in a process of its own."""

import tempfile
from pathlib import Path

import numpy as np

from edge.bench.subject import begin, tell, timed
from edge.memory.store import Vlpg, VlpgConfig

DIM = 512  # as of most encoders of pictures and words
HITS = 50  # k of [V] Sec. III-C
QUESTIONS = 200
OFFERS = 100
NODES = 2000


def unit_vectors(count: int, seed: int) -> np.ndarray:
    """``(count, DIM)`` float32."""
    rows = np.random.default_rng(seed).normal(size=(count, DIM)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def filled(path, nodes: int, regions: int = 1) -> Vlpg:
    """A memory with so many nodes, half a metre apart, of ``regions`` vectors each."""
    memory = Vlpg.open(path, "bench", "0" * 64, DIM, VlpgConfig(limit=nodes))
    side = int(np.ceil(np.sqrt(nodes)))
    for node, vectors in enumerate(unit_vectors(nodes * regions, 0).reshape(nodes, regions, DIM)):
        pose = np.array([0.5 * (node % side), 0.5 * (node // side), 0.0])
        memory.add(0.1 * node, pose, 1e-4 * np.eye(3), vectors, np.zeros(regions))
    memory.flush()
    return memory


def main() -> None:
    begin()
    questions, views = unit_vectors(QUESTIONS, 1), unit_vectors(OFFERS, 2)
    side = 0.5 * np.ceil(np.sqrt(NODES))
    places = np.random.default_rng(3).uniform([0, 0, -np.pi], [side, side, np.pi], (OFFERS, 3))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "home.vlpg"
        filled(path, NODES).close()
        disk = sum(file.stat().st_size for file in path.parent.iterdir())

        def offer(i):
            memory.add(float(NODES + i), places[i], 1e-4 * np.eye(3), views[i : i + 1], np.zeros(1))

        with Vlpg.open(path, "bench", "0" * 64, DIM, VlpgConfig(limit=NODES)) as memory:
            ram = memory.nbytes
            stages = {
                f"search {NODES} vectors": timed(lambda i: memory.search(questions[i], HITS), QUESTIONS),
                "offer a view to a full memory": timed(offer, OFFERS, 0),
            }
    with filled(":memory:", 10 * NODES // 4, 4) as memory:
        stages[f"search {10 * NODES} vectors"] = timed(lambda i: memory.search(questions[i], HITS), QUESTIONS)
    sizes = {f"memory, {NODES} nodes of a {DIM}-d vector, RAM": ram / 1e6}
    tell(stages, sizes | {f"memory, {NODES} nodes of a {DIM}-d vector, disk": disk / 1e6})


if __name__ == "__main__":
    main()
