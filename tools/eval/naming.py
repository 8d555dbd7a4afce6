"""Naming pictures: all names of a vocabulary ranked for each picture, and what is mistaken for what."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from edge.perception.prompts import contrast

SHOWN = 5  # names an answer keeps


class Vocabulary:
    """Names, and their prompts' unit vectors of one encoder."""

    def __init__(self, encoder, names: list[str]):
        """The first prompt of [V] Eq. 2 is asked for each name, each name once."""
        self.names = list(dict.fromkeys(names))
        self._encoder = encoder
        self._texts = encoder.encode_text([contrast(name)[0] for name in self.names])

    def ask(self, picture: str, rgb: np.ndarray, truths: tuple[str, ...]) -> "Answer":
        """Rank all names for RGB ``(H, W, 3)``; ``truths`` are the names, of this vocabulary, that are right."""
        ranking = np.argsort(-(self._texts @ self._encoder.encode_image(rgb).vectors[0]), kind="stable")
        right = {self.names.index(truth) for truth in truths}
        rank = next(i for i, k in enumerate(ranking) if k in right)
        return Answer(picture, truths[0], rank, tuple(self.names[k] for k in ranking[:SHOWN]))


@dataclass(frozen=True)
class Answer:
    """What one picture was called: ``rank`` 0 if a right name came first, and the ``best`` names in order."""

    picture: str
    truth: str
    rank: int
    best: tuple[str, ...]


def share(answers: list[Answer], first: int) -> float:
    """Share of the answers with a right name among the ``first``; NaN without answers."""
    return round(float(np.mean([answer.rank < first for answer in answers])), 4) if answers else float("nan")


def confusions(answers: list[Answer], count: int) -> list[tuple[str, str, int]]:
    """The most frequent mistakes: the truth, what was said instead, and of how many pictures."""
    wrong = Counter((answer.truth, answer.best[0]) for answer in answers if answer.rank > 0)
    ordered = sorted(wrong.items(), key=lambda item: (-item[1], item[0]))
    return [(*names, times) for names, times in ordered[:count]]


def said_too_often(answers: list[Answer], count: int) -> list[tuple[str, int]]:
    """The names most often said of something else, and of how many pictures."""
    wrong = Counter(answer.best[0] for answer in answers if answer.rank > 0)
    return sorted(wrong.items(), key=lambda item: (-item[1], item[0]))[:count]
