"""Real photographs that need no download: those that scikit-image and scikit-learn carry in their packages."""

import importlib.util
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from firmware_sim.furniture import Furniture


@dataclass(frozen=True)
class Photograph:
    """A file of a package, plain names of what it shows, and to whom it is owed; without credit it is not reprinted."""

    package: str
    file: str
    truths: tuple[str, ...]
    credit: str


_CC_BY = "CC BY 2.0 (creativecommons.org/licenses/by/2.0), made smaller"
PHOTOGRAPHS = (
    Photograph("skimage", "data/astronaut.png", ("astronaut", "woman"), "NASA, public domain"),
    Photograph("skimage", "data/camera.png", ("photographer", "camera", "man"), "Lav Varshney, CC0"),
    Photograph("skimage", "data/chelsea.png", ("cat",), "Stefan van der Walt, CC0"),
    Photograph("skimage", "data/coffee.png", ("cup of coffee", "coffee cup", "espresso"), "Rachel Michetti, CC0"),
    Photograph("skimage", "data/coins.png", ("coins",), "Brooklyn Museum, no known restrictions"),
    Photograph("skimage", "data/rocket.jpg", ("rocket",), "SpaceX, public domain"),
    Photograph("skimage", "data/motorcycle_left.png", ("motorcycle", "motorbike"), ""),
    Photograph("skimage", "data/brick.png", ("brick wall",), "CC0Textures, CC0"),
    Photograph("skimage", "data/grass.png", ("grass",), "Linolafett, CC0"),
    Photograph("skimage", "data/gravel.png", ("gravel",), "CC0Textures, CC0"),
    Photograph("skimage", "data/moon.png", ("moon",), "NASA, public domain"),
    Photograph("sklearn", "datasets/images/china.jpg", ("temple", "palace"), f"danielbuechele, {_CC_BY}"),
    Photograph("sklearn", "datasets/images/flower.jpg", ("flower",), f"vultilion, {_CC_BY}"),
)

# What a person might also have said: everyday nouns that are not what any of the photographs is of.
DISTRACTORS = (
    "dog bird fish horse cow sheep elephant lion butterfly spider snake rabbit car bus truck train bicycle airplane "
    "boat ship helicopter tree forest mountain beach river desert sky cloud snow fire bridge road street house church "
    "castle tower lighthouse child baby crowd face hand shoe hat shirt dress glasses book newspaper letter map "
    "painting statue pizza sandwich cake apple banana orange salad soup bread bottle wine glass bowl plate fork knife "
    "spoon computer keyboard telephone television radio watch guitar piano drum ball football kite balloon umbrella "
    "suitcase backpack scissors hammer ladder rope candle lamp chair table bed sofa window door stairs fence wheel "
    "engine clock"
).split()


def vocabulary() -> list[str]:
    """The names of the furniture pack, those of the photographs' contents, and ``DISTRACTORS``."""
    pack = (model.name.lower() for model in Furniture.load().values())
    names = [*pack, *(truth for photograph in PHOTOGRAPHS for truth in photograph.truths), *DISTRACTORS]
    return sorted(set(names))


def load(photograph: Photograph) -> np.ndarray | None:
    """RGB ``(H, W, 3)``; None where the package is not installed, or no longer carries it."""
    spec = importlib.util.find_spec(photograph.package)
    if spec is None or spec.origin is None:
        return None
    # Read from the package's folder: importing it would bring in SciPy and more.
    bgr = cv2.imread(str(Path(spec.origin).parent / photograph.file))
    return None if bgr is None else cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)
