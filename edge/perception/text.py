"""The text tower: prompts to unit vectors. Opened only where, and when, a prompt must be encoded."""

import numpy as np

from edge.perception.session import open_session
from models.manifest import Manifest


class TextTower:
    """Tokenizer and text graph of a manifest, open while prompts are encoded: together they take 27 MB.

    It remembers nothing: that is ``edge.memory.prompts``, in front of it wherever prompts come again.
    """

    def __init__(self, manifest: Manifest, threads: int = 1):
        self._manifest, self._threads = manifest, threads
        self._tokenizer = self._session = None

    def open(self) -> None:
        """Open it, and leave it so: for who has others waiting, as it takes about 0.2 s."""
        if self._session is None:
            from tokenizers import Tokenizer

            text = self._manifest.text
            self._tokenizer = Tokenizer.from_file(str(self._manifest.folder / text.tokenizer))
            self._tokenizer.no_padding()
            if text.pad_id is not None:
                self._tokenizer.enable_padding(length=text.context_length, pad_id=text.pad_id)
            self._tokenizer.enable_truncation(text.context_length)
            self._session = open_session(self._manifest.folder / text.graph, self._threads)
            self._inputs = [graph_input.name for graph_input in self._session.get_inputs()]  # some need no mask

    def tokens(self, text: str) -> list[int]:
        """Ids of a prompt as the graph sees them: with the first and the last special token, cut to the context."""
        return self._encoding(text).ids

    def encode(self, texts: list[str]) -> np.ndarray:
        """``(N, D)`` float32 unit rows. One prompt a run, so that a vector never depends on what else was asked."""
        keep = self._session is not None
        try:
            rows = [self._encode_one(text) for text in texts]
        finally:
            if not keep:
                self._tokenizer = self._session = None
        return np.stack(rows) if rows else np.zeros((0, self._manifest.dim), np.float32)

    def _encode_one(self, text: str) -> np.ndarray:
        encoding = self._encoding(text)
        tokens = {"input_ids": encoding.ids, "attention_mask": encoding.attention_mask}
        feeds = {name: np.array([tokens[name]], np.int64) for name in self._inputs}
        return self._session.run(None, feeds)[0][0]

    def _encoding(self, text: str):
        self.open()
        # A lone surrogate (half an emoji) is valid in a Python string but has no UTF-8 form. It is left out, as the
        # original tokenizer (Devlin et al. 2019) leaves out all characters of category C.
        return self._tokenizer.encode(text.encode("utf-8", "ignore").decode("utf-8"))
