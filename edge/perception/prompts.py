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
    """What is searched for: its ``name`` and the unit vectors (D,) of the two prompts of [V] Eq. 2."""

    name: str
    positive: np.ndarray
    negative: np.ndarray

    @classmethod
    def of(cls, name: str, encoder) -> "Target":
        """Encode the two prompts with ``encoder.encode_text``. Raises ValueError when the name is empty."""
        positive, negative = encoder.encode_text(list(contrast(name)))
        return cls(_clean(name), positive, negative)

    @property
    def direction(self) -> np.ndarray:
        """``(D,)``: the softmax over the two prompts is ``sigmoid(scale * vector . direction)``."""
        return self.positive - self.negative


def _clean(name: str) -> str:
    name = " ".join(name.split())
    if not name:
        raise ValueError("Say what to look for: the object's name is empty.")
    return name
