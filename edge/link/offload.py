"""The text tower, wherever it is: on the robot, or on a host that may come and go."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from edge.link.alive import Watch
from edge.link.exchange import NoAnswer, ask
from edge.link.requests import EmbedText, EmbedTextReply, RequestError
from edge.memory.prompts import PromptMemory

Mode = Literal["host", "never", "auto"]


@dataclass(frozen=True)
class OffloadConfig:
    """How long to wait for a host, and how soon to try again."""

    timeout: float = 1.0  # s; a prompt takes a host 5 ms, so it is gone or hopelessly busy after that
    patience: float = 10.0  # s during which a host that did not answer is not asked again


class OffloadedEncoder:
    """An encoder whose image side is on board and whose text side is the host's or, if need be, its own.

    Everything but ``encode_text`` is the given encoder's. A prompt that was encoded before, here or by a host, is
    remembered; for others there are modes: ``host`` never opens the text tower, ``never`` does not ask a host, and
    ``auto`` asks one that is alive and answers in time, else opens the tower and goes on.

    Searching the robot's own memory is never offloaded: it takes less time than a round trip.
    """

    def __init__(self, session, encoder, mode: Mode, tower, prompts: Path | None = None, config=None):
        """``tower.encode(texts) -> (N, D)`` is the robot's own; ``prompts`` is the file of ``PromptMemory``."""
        self.mode = mode
        self.config = config or OffloadConfig()
        self._session, self._encoder, self._tower = session, encoder, tower
        self._prompts = PromptMemory(self._encode_new, encoder.digest, encoder.dim, prompts)
        self._watch = Watch(session, "host/alive/*") if mode != "never" else None
        self._not_before = -np.inf  # s, monotonic

    def __getattr__(self, name):
        if name == "_encoder":  # not set yet, while the constructor runs
            raise AttributeError(name)
        return getattr(self._encoder, name)

    @property
    def host_alive(self):
        """Whether a host has declared itself alive."""
        return self._watch is not None and bool(self._watch.alive)

    def encode_text(self, texts):
        """Prompts to ``(N, D)`` float32 unit rows.

        Raises RequestError when a prompt is new, the mode is ``host``, and no host answers or it runs another encoder.
        """
        return self._prompts.encode(texts)

    def _encode_new(self, texts):
        if self.mode == "host":
            if not self.host_alive:
                raise RequestError("no host is there to encode text; start `vlpg host`, or use --offload auto")
            return self._ask(texts)
        if self.mode == "auto" and self.host_alive and time.monotonic() >= self._not_before:
            try:
                return self._ask(texts)
            except RequestError:  # slow, dying, or of another version: the robot goes on alone
                self._not_before = time.monotonic() + self.config.patience
        return self._tower.encode(texts)

    def _ask(self, texts):
        request = EmbedText(list(texts), self._encoder.digest)
        try:
            reply = ask(self._session, "host/embed_text", request, EmbedTextReply, self.config.timeout)
        except NoAnswer as error:
            raise RequestError(f"the host did not answer within {self.config.timeout:g} s; try again") from error
        vectors = reply.vectors.numpy()
        if vectors.shape != (len(texts), self._encoder.dim) or not np.isfinite(vectors).all():
            raise RequestError(f"the host sent vectors of shape {vectors.shape}")
        return vectors
