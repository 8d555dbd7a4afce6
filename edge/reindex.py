"""``vlpg reindex``: have another encoder look again at the pictures that a store kept."""

import argparse
from pathlib import Path

from edge.memory.database import StoreError
from edge.memory.reindex import Reindexed, reindex
from models.manifest import Manifest, ModelError, resolve


def reindex_store(store: Path, model: str | None) -> tuple[str, Reindexed]:
    """Rewrite ``store`` for the encoder ``model`` (default: the shipped one); its name, and what became of the nodes.

    Raises StoreError or ModelError; the store is then as it was.
    """
    import cv2
    import numpy as np

    from edge.perception.close_look import look_closely, to_remember
    from edge.perception.encoder import Encoder

    manifest = Manifest.load(resolve(model) if model else resolve())
    manifest.verify(text=False)
    encoder = Encoder(manifest, text=False)

    def embed(jpeg: bytes, hfov: float):
        bgr = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) if jpeg else None
        if bgr is None:
            return None
        return to_remember(look_closely(encoder, cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), hfov=hfov))

    return encoder.name, reindex(store, encoder.name, encoder.digest, encoder.dim, embed)


def main(arguments: list[str] | None = None) -> None:
    """``python -m edge.reindex``."""
    parser = argparse.ArgumentParser(
        prog="vlpg reindex", description="Move a home's store to another encoder, by looking again at its pictures."
    )
    parser.add_argument("store", type=Path, help="a home's store, such as home.vlpg")
    parser.add_argument("--model", help="name or folder of the encoder (default: the shipped one)")
    options = parser.parse_args(arguments)
    try:
        name, nodes = reindex_store(options.store, options.model)
    except (StoreError, ModelError) as error:
        parser.exit(2, f"vlpg reindex: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, f"\nvlpg reindex: stopped; {options.store} is as it was\n")
    print(f"{options.store} is now {name}'s: {nodes.embedded} nodes looked at again, {nodes.withdrawn} withdrawn")


if __name__ == "__main__":
    main()
