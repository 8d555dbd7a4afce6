"""All names of the training models, their text vectors, and which of them a part of a picture may be called."""

from collections.abc import Callable

import numpy as np
import torch

from tools.assets.catalog import Entry
from tools.train.words import NOTHING, TEMPLATES, names


class Vocabulary:
    """``names`` (V); ``called`` (M, V) bool: what each model may be called; ``directions`` (T, V, D): the text vectors
    in each template less that of "something else", t_obj - t_else of [V] Eq. 2."""

    def __init__(self, entries: list[Entry], encode: Callable[[list[str]], np.ndarray]):
        called = [names(entry) for entry in entries]
        self.names = sorted({name for group in called for name in group})
        place = {name: i for i, name in enumerate(self.names)}
        table = np.zeros((len(entries), len(self.names)), np.float32)
        for row, group in enumerate(called):
            table[row, [place[name] for name in group]] = 1
        self.called = torch.tensor(table)
        nothing = encode([NOTHING])[0]
        texts = np.stack([encode([template.format(name) for name in self.names]) for template in TEMPLATES])
        self.directions = torch.tensor(texts - nothing)
        self.cosines = torch.tensor(texts[1] @ texts[1].T)  # of the bare names

    def to(self, device: torch.device) -> None:
        """Move the tables, in place."""
        for name in ("called", "directions", "cosines"):
            setattr(self, name, getattr(self, name).to(device))

    def truth(self, named, doubtful, synonym: float):
        """For pictures with ``named`` and ``doubtful`` models (B, M): names (B, V) that hold, and that may be denied.

        Names closer than the cosine ``synonym`` to one that holds are not denied.
        """
        positive = named.float() @ self.called > 0
        close = positive.float() @ (self.cosines > synonym).float() > 0
        maybe = doubtful.float() @ self.called > 0
        return positive, ~(positive | close | maybe)
