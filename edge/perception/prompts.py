"""The words around an object's name, and the text directions they make."""

from dataclasses import dataclass

import numpy as np

SOMETHING_ELSE = "A photo of something else"

# [U] Table I.
ENSEMBLE = (
    "Seems like there is a {} ahead",
    "A place where {} can be found",
    "A {} can be in the vicinity",
    "Seems like a {} is ahead",
    "A {} is in the vicinity",
    "{} likely ahead",
    "{}",
)

# What else a thing in a home may be. A few dozen common names do: twice as many told things apart no better.
EVERYDAY = (
    *("table", "chair", "bed", "sofa", "lamp", "door", "window", "wall", "floor", "curtain", "carpet"),
    *("cabinet", "shelf", "book", "television", "computer", "refrigerator", "oven", "sink", "toilet", "bathtub"),
    *("shower", "mirror", "towel", "pillow", "plant", "vase", "picture", "clock", "toy", "bag", "box", "bottle"),
    *("bowl", "bicycle", "piano", "guitar", "radiator", "washing machine", "trash can", "shoe", "desk", "stool"),
    "wardrobe",
)


def contrast(name: str) -> tuple[str, str]:
    """The two prompts of [V] Eq. 2 for an object's ``name``.

    Raises:
        ValueError: the name is empty.
    """
    return f"A photo of {_clean(name)}", SOMETHING_ELSE


def ensemble(name: str) -> list[str]:
    """The seven prompts of [U] Table I for an object's ``name``.

    Raises:
        ValueError: the name is empty.
    """
    return [prompt.format(_clean(name)) for prompt in ENSEMBLE]


@dataclass(frozen=True)
class Target:
    """What is searched for: its ``name``, the unit vectors (D,) of the two prompts of [V] Eq. 2, and ``others`` (N, D).

    ``others`` are the prompts of "something else" and of everyday things. The first alone finds the view that shows the
    target among views of everything; which of a few things it is, is told by what else each of them looks like.
    """

    name: str
    positive: np.ndarray
    negative: np.ndarray
    others: np.ndarray

    @classmethod
    def of(cls, name: str, encoder) -> "Target":
        """Encode the prompts with ``encoder.encode_text``. Raises ValueError when the name is empty."""
        everyday = [contrast(other)[0] for other in EVERYDAY]
        positive, negative, *others = encoder.encode_text([*contrast(name), *everyday])
        return cls(_clean(name), positive, negative, np.stack([negative, *others]))

    @property
    def direction(self) -> np.ndarray:
        """``(D,)``: the softmax over the two prompts is ``sigmoid(scale * vector . direction)``."""
        return self.positive - self.negative


def _clean(name: str) -> str:
    name = " ".join(name.split())
    if not name:
        raise ValueError("Say what to look for: the object's name is empty.")
    return name
