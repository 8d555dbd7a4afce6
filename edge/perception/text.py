"""The text tower: prompts to unit vectors. Loaded only where the text tower is on board."""

from collections import OrderedDict

import numpy as np

from edge.perception.session import open_session
from models.manifest import Manifest


class TextTower:
    """Tokenizer and text graph of a manifest. Remembers the latest prompts: a mission asks the same few again."""

    REMEMBERED = 256  # prompts; 0.4 MB at 384 dimensions

    def __init__(self, manifest: Manifest, threads: int = 1):
        from tokenizers import Tokenizer

        self._tokenizer = Tokenizer.from_file(str(manifest.folder / manifest.text.tokenizer))
        self._tokenizer.no_padding()
        if manifest.text.pad_id is not None:
            self._tokenizer.enable_padding(length=manifest.text.context_length, pad_id=manifest.text.pad_id)
        self._tokenizer.enable_truncation(manifest.text.context_length)
        self._session = open_session(manifest.folder / manifest.text.graph, threads)
        self._inputs = [graph_input.name for graph_input in self._session.get_inputs()]  # some need no mask
        self._dim = manifest.dim
        self._known: OrderedDict[str, np.ndarray] = OrderedDict()

    def encode(self, texts: list[str]) -> np.ndarray:
        """``(N, D)`` float32 unit rows. One prompt a run, so that a vector never depends on what else was asked."""
        rows = [self._encode_one(text) for text in texts]
        return np.stack(rows) if rows else np.zeros((0, self._dim), np.float32)

    def _encode_one(self, text: str) -> np.ndarray:
        if text not in self._known:
            # A lone surrogate (half an emoji) is valid in a Python string but has no UTF-8 form.
            encoding = self._tokenizer.encode(text.encode("utf-8", "replace").decode("utf-8"))
            tokens = {"input_ids": encoding.ids, "attention_mask": encoding.attention_mask}
            feeds = {name: np.array([tokens[name]], np.int64) for name in self._inputs}
            self._known[text] = self._session.run(None, feeds)[0][0]
            if len(self._known) > self.REMEMBERED:
                self._known.popitem(last=False)
        self._known.move_to_end(text)
        return self._known[text]
