"""Whether a graph says what the source framework says, and how fast."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from tokenizers import Tokenizer

from edge.perception.session import open_session
from models.manifest import ModelError
from tools.models.pair import IMAGE, TEXT, TOKENIZER, Pair

TOLERANCE = 1e-3  # between the float32 graph and the source framework, of any component of a unit vector
PROMPTS = (
    "A photo of a teddy bear", "a chair", "A photo of something else", "Seems like there is a lamp ahead", "fridge",
    "the small red cup on a table next to the window, in a kitchen that somebody has left in a hurry", "TV", "2 beds!",
)  # fmt: skip
_RUNS = 15


class Truth:
    """What the source framework says of some pictures and prompts."""

    def __init__(self, pair: Pair, pixels: list[np.ndarray], folder: Path):
        """``pixels`` (1, 3, H, W) each; ``folder`` has the exported graphs and tokenizer."""
        self._folder, self._pixels, self._ids = folder, pixels, token_ids(pair, folder / TOKENIZER)
        self._pictures = np.stack([pair.see(image) for image in pixels])
        self._prompts = np.stack([pair.read(prompt) for prompt in PROMPTS])

    def check_export(self) -> float:
        """The largest difference of the float32 graphs' vectors; raises ModelError above ``TOLERANCE``."""
        worst = max(
            np.abs(self._see(self._folder / IMAGE) - self._pictures).max(),
            np.abs(self._read(self._folder / TEXT) - self._prompts).max(),
        )
        if not worst <= TOLERANCE:
            raise ModelError(
                f"The exported graphs differ from the source by {worst:.1e}; this model cannot be imported."
            )
        return float(worst)

    def image_cosine(self, graph: Path) -> float:
        """Median over the pictures."""
        return _median_cosine(self._see(graph), self._pictures)

    def text_cosine(self, graph: Path) -> float:
        """Median over the prompts."""
        return _median_cosine(self._read(graph), self._prompts)

    def image_milliseconds(self, graph: Path) -> float:
        """Median for one picture, one thread."""
        session = open_session(graph)
        return _milliseconds(lambda: session.run(None, {"image": self._pixels[0]}))

    def text_milliseconds(self, graph: Path) -> float:
        """Median for a short prompt, one thread."""
        run = _reader(graph)
        return _milliseconds(lambda: run(self._ids[0]))

    def saliency_milliseconds(self, graph: Path) -> float:
        """Median for one Grad-CAM, one thread."""
        tower, session = open_session(self._folder / IMAGE), open_session(graph, exact=True)
        names = [output.name for output in tower.get_outputs()[1:]]
        feeds = dict(zip(names, tower.run(names, {"image": self._pixels[0]})))
        feeds["direction"] = self._prompts[0] - self._prompts[-1]
        return _milliseconds(lambda: session.run(None, feeds))

    def _see(self, graph: Path) -> np.ndarray:
        session = open_session(graph)
        return np.stack([session.run(["vectors"], {"image": image})[0][0] for image in self._pixels])

    def _read(self, graph: Path) -> np.ndarray:
        run = _reader(graph)
        return np.stack([run(ids) for ids in self._ids])


def token_ids(pair: Pair, tokenizer: Path) -> list[np.ndarray]:
    """``PROMPTS`` as the robot's text tower reads them, (1, T) int64 each."""
    reader = Tokenizer.from_file(str(tokenizer))
    reader.no_padding()
    if pair.pad_id is not None:
        reader.enable_padding(length=pair.context_length, pad_id=pair.pad_id)
    reader.enable_truncation(pair.context_length)
    return [np.array([reader.encode(prompt).ids], np.int64) for prompt in PROMPTS]


def _reader(graph: Path) -> Callable[[np.ndarray], np.ndarray]:
    session = open_session(graph)
    known = [graph_input.name for graph_input in session.get_inputs()]

    def run(ids):
        feeds = {"input_ids": ids, "attention_mask": np.ones_like(ids)}
        return session.run(None, {name: feeds[name] for name in known})[0][0]

    return run


def _median_cosine(found: np.ndarray, expected: np.ndarray) -> float:
    norms = np.linalg.norm(found, axis=1) * np.linalg.norm(expected, axis=1)
    kept = norms > 0
    return float(np.median((found * expected).sum(1)[kept] / norms[kept])) if kept.any() else 0.0


def _milliseconds(run: Callable[[], object]) -> float:
    """Median time of this thread, the only one that works: what else the machine does counts little."""
    run()
    times = []
    for _ in range(_RUNS):
        started = time.thread_time()
        run()
        times.append(time.thread_time() - started)
    return 1e3 * float(np.median(times))
