"""Stage ``reference``: what PyTorch in float32 says of a few pictures and prompts, for ``vlpg models verify``."""

from pathlib import Path

import cv2
import numpy as np
import torch
from tokenizers import Tokenizer

from edge.perception.preprocess import preprocess
from edge.perception.prompts import contrast, ensemble
from models.manifest import Image
from tools.models.reference import Reference, decode, encode
from tools.train.homes import shoot
from tools.train.image_tower import ImageTower
from tools.train.text_tower import TextTower

HOME, VIEWS = 40, 8  # a generated home that is not among those of the evaluation, and pictures of it
CLOSE_UPS = 8  # of the held-out models
NAMES = ("teddy bear", "floor lamp", "refrigerator", "coffee table", "pool table", "basketball")


def make_reference(tower: ImageTower, image: Image, text: TextTower, tokenizer: Path, held_out: Path) -> Reference:
    """Pictures are CC0 furniture: views of a home, and close-ups out of the folder ``held_out``."""
    files = sorted(held_out.glob("*.png"))
    close_ups = [cv2.cvtColor(cv2.imread(str(file)), cv2.COLOR_BGR2RGB) for file in files[:: len(files) // CLOSE_UPS]]
    jpegs = [encode(rgb) for rgb in [shot.rgb for shot in shoot(HOME, VIEWS)[1]] + close_ups[:CLOSE_UPS]]
    prompts = ["", *(prompt for name in NAMES for prompt in contrast(name)), *ensemble("vase")]
    prompts = list(dict.fromkeys(prompts))
    words = Tokenizer.from_file(str(tokenizer))
    words.no_padding()
    with torch.no_grad():
        vectors = [tower(torch.tensor(preprocess(decode(jpeg), image)))[0].numpy() for jpeg in jpegs]
        ids = [torch.tensor([words.encode(prompt).ids]) for prompt in prompts]
        rows = [text(row, torch.ones_like(row))[0].numpy() for row in ids]
    return Reference(jpegs, np.stack(vectors), prompts, np.stack(rows))
