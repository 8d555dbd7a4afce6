"""``python -m edge.bench.encoder MODEL board|host``: the towers alone, in a process of their own."""

import sys

import numpy as np

from edge.bench.subject import begin, tell, timed
from edge.perception.encoder import Encoder
from edge.perception.text import TextTower
from models.manifest import Manifest, resolve

PASSES = 100
PROMPTS = 10


def main() -> None:
    model, text = sys.argv[1:]
    begin()
    manifest = Manifest.load(resolve(model))
    encoder, rng = Encoder(manifest, text=False), np.random.default_rng(0)
    rgb = rng.integers(0, 256, (240, 320, 3), dtype=np.uint8)
    view, direction = encoder.encode_image(rgb), rng.normal(size=manifest.dim)
    stages = {
        "encode a picture": timed(lambda _: encoder.encode_image(rgb), PASSES),
        "Grad-CAM": timed(lambda _: encoder.saliency(view, direction), PASSES),
    }
    if text == "board":
        tower = TextTower(manifest)
        stages["open the text tower, encode a prompt, close it"] = timed(lambda i: tower.encode([f"A {i}"]), PROMPTS, 1)
        tower.open()
        stages["encode a prompt"] = timed(lambda i: tower.encode([f"A photo of teddy bear {i}"]), PASSES)
    tell(stages)


if __name__ == "__main__":
    main()
