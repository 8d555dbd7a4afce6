"""What every framework's model becomes: a pair of towers that can be exported, and can say what they should give."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

IMAGE, SALIENCY, TEXT, TOKENIZER = "image.onnx", "saliency.onnx", "text.onnx", "tokenizer.json"
CLIP_MEAN, CLIP_STD = (0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711)


@dataclass(frozen=True)
class Pair:
    """A vision-language pair of a source framework."""

    source: str  # where it comes from, as the user would say it
    licence: str  # of the weights; empty: unknown
    kind: str  # the image tower in a few words
    height: int  # px
    width: int  # px
    mean: tuple[float, ...]
    std: tuple[float, ...]
    logit_scale: float
    context_length: int  # tokens
    pad_id: int | None  # as in models.manifest.Text
    # Writes IMAGE, SALIENCY, TEXT (float32 graphs) and TOKENIZER into a folder.
    export: Callable[[Path], None]
    # What the source framework itself says: pixels (1, 3, H, W) float32 to (D,), and a prompt to (D,), unit vectors.
    see: Callable[[np.ndarray], np.ndarray]
    read: Callable[[str], np.ndarray]
