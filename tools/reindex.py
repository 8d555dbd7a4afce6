"""``vlpg reindex``: have another encoder look again at the pictures that a store kept."""

from pathlib import Path

import cv2
import numpy as np

from edge.memory.reindex import Reindexed, reindex
from edge.perception.close_look import look_closely, to_remember
from edge.perception.encoder import Encoder
from models.manifest import Manifest, resolve


def reindex_store(store: Path, model: str | None) -> tuple[str, Reindexed]:
    """Rewrite ``store`` for the encoder ``model`` (default: the shipped one); its name, and what became of the nodes.

    Raises StoreError or ModelError; the store is then as it was.
    """
    manifest = Manifest.load(resolve(model) if model else resolve())
    manifest.verify()
    encoder = Encoder(manifest, text=False)

    def embed(jpeg: bytes, hfov: float):
        bgr = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        return to_remember(look_closely(encoder, cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), hfov=hfov))

    return encoder.name, reindex(store, encoder.name, encoder.digest, encoder.dim, embed)
