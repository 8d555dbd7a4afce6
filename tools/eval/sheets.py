"""The encoder's answers as contact sheets: everything held out, what it confuses most, and real photographs."""

from pathlib import Path

import cv2
import numpy as np

from tools.eval.contact_sheet import BAD, GOOD, INK, NEAR, Tile, contact_sheet, save
from tools.eval.naming import Answer, confusions
from tools.eval.photographs import PHOTOGRAPHS, load

HELD_OUT, CONFUSIONS, PHOTOS = "held-out.jpg", "confusions.jpg", "photographs.jpg"
_TOP = 3  # names below a picture
_EXAMPLES = 3  # of a confusion


def held_out_sheet(answers: list[Answer], pictures: Path, path: Path) -> None:
    """Each model once, from the front: its name, and the three that the encoder finds likeliest."""
    front = [answer for answer in answers if answer.picture.endswith(".1.png")]
    save(contact_sheet([_tile(answer, _read(pictures / answer.picture)) for answer in front], 15, (104, 78)), path)


def confusions_sheet(answers: list[Answer], pictures: Path, path: Path, count: int = 8) -> None:
    """Up to three pictures of each of the most frequent confusions, one confusion a row of a column."""
    tiles = []
    for truth, said, times in confusions(answers, count):
        wrong = [answer for answer in answers if (answer.truth, answer.best[0]) == (truth, said) and answer.rank]
        words = ((truth, INK), (f"called {said}", BAD), (f"{times} pictures", INK))
        rows = [Tile(_read(pictures / answer.picture), words) for answer in wrong[:_EXAMPLES]]
        blank = Tile(np.full((3, 4, 3), 255, np.uint8), (("", INK),))
        tiles += rows + [blank] * (_EXAMPLES - len(rows))
    save(contact_sheet(tiles, 2 * _EXAMPLES), path)


def photographs_sheet(answers: list[Answer], path: Path) -> None:
    """The photographs that may be reprinted, each with what it shows and the three likeliest names."""
    credited = {photograph.file: photograph for photograph in PHOTOGRAPHS if photograph.credit}
    tiles = [_tile(answer, load(credited[answer.picture])) for answer in answers if answer.picture in credited]
    save(contact_sheet(tiles, 4, (200, 150)), path)


def _tile(answer: Answer, rgb: np.ndarray) -> Tile:
    colour = GOOD if answer.rank == 0 else NEAR if answer.rank < _TOP else BAD
    names = [(f"{i}. {name}", colour if answer.rank == i - 1 else INK) for i, name in enumerate(answer.best[:_TOP], 1)]
    return Tile(rgb, ((answer.truth, colour), *names))


def _read(path: Path) -> np.ndarray:
    return cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB)
