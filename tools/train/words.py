"""Words of the training data: what each model may be called, prompt templates, and the names of ImageNet's classes."""

import re
from pathlib import Path

import numpy as np

from tools.assets.catalog import Entry

# Words a user, [V] Eq. 2 and [U] Table I put around an object's name.
TEMPLATES = (
    "A photo of {}",
    "{}",
    "a photo of a {}",
    "Seems like there is a {} ahead",
    "A {} is in the vicinity",
    "a {} in a room",
    "the {}",
    "a picture of a small {}",
)
NOTHING = "A photo of something else"  # the second prompt of [V] Eq. 2

# Tags that say where or how, not what: as names they would call every garden chair a garden.
_NOT_NAMES = frozenset(
    "outdoor indoor exterior interior deck patio garden kid kids child children double single dining dinner appliance "
    "electronics food drink decoration decorative nature office school sport hygiene clothing person people game "
    "electricity equipment accessory accessories summer winter home house wood wooden metal design modern set".split()
)
# Words before a noun that make it no other thing: an orange chair is a chair.
_COLOURS = frozenset(
    "black blue brown cherry dark gray green grey maple opened orange red simple white wood wooden yellow".split()
)


def noun(entry: Entry) -> str:
    """The model's name in lower case, without trailing numbers."""
    return re.sub(r"[\s\d:]+$", "", entry.name.lower()).strip()


def names(entry: Entry) -> list[str]:
    """What the model may be called: its own name first, the same without colours, then the tags that name things."""
    own = noun(entry)
    plain = " ".join(word for word in own.split() if word not in _COLOURS)
    tags = [tag.lower() for tag in entry.tags if tag.lower() not in _NOT_NAMES]
    return list(dict.fromkeys([own, plain or own, *tags]))


def imagenet_names(folder: Path) -> list[list[str]]:
    """WordNet's names of the 1000 classes, in the order of the classifier's outputs."""
    lemmas = dict(line.split("\t") for line in (folder / "imagenet_lemmas.txt").read_text().splitlines())
    synsets = (folder / "imagenet_synsets.txt").read_text().split()
    return [[name.strip() for name in lemmas[synset].split(",")] for synset in synsets]


def concept_vectors(classes: list[list[str]], encode) -> np.ndarray:
    """``(len(classes), D)`` unit rows: mean text embedding over the names and two templates of each class."""
    prompts = [[template.format(name) for name in group for template in TEMPLATES[:2]] for group in classes]
    rows = np.stack([encode(group).mean(0) for group in prompts])
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)
