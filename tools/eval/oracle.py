"""An encoder that cannot be wrong, for telling the system's faults from the encoder's.

It reads the true labels of what is in the picture from the simulator's instance buffer, which no part of the robot
sees, and answers with vectors of the same kind as a real encoder's: everything downstream runs unchanged.
"""

import hashlib

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.perception.encoder import View, column_bearings
from edge.perception.prompts import SOMETHING_ELSE
from firmware_sim.world import World


class OracleEncoder:
    """Vectors over one axis per noun, one for everything else that pictures show, and one for nouns not in the home."""

    name = "oracle"
    logit_scale = 20.0  # as a real encoder's: a thing that fills a picture scores higher than a speck
    MIN_PIXELS = 60  # of 320x240; smaller than about 8x8 pixels, an object cannot be told by anyone
    OTHER = 30  # pixels of "something else" in every picture: it beats what is not there, and nothing that is
    REGIONS = ((0.0, 1.0), (0.0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1.0))
    CELLS = (15, 20)  # rows, columns of the feature map

    def __init__(self, world: World, newcomers: set[str] = frozenset()):
        """``newcomers``: nouns that it is to know although no such thing is in the home yet."""
        self._world = world
        self._noun_of = {thing_id: thing.model.name.lower() for thing_id, thing in world.house.objects.items()}
        self._nouns = sorted(newcomers.union(self._noun_of.values()))
        self.dim = len(self._nouns) + 2
        self.digest = hashlib.sha256("\n".join(self._nouns).encode()).hexdigest()

    def encode_text(self, texts: list[str]) -> np.ndarray:
        """``(N, dim)``: the axis of the longest noun of this home that a prompt names."""
        return np.eye(self.dim, dtype=np.float32)[[self._axis(text.lower()) for text in texts]]

    def confidence(self, seen: float, remembered: float) -> float:
        """What it sees is there."""
        return 0.99

    def relevance(self, cosine):
        """Relevance in [0, 1]: what fills a twentieth of the picture is there for certain; it guesses from no cues."""
        return np.clip(np.asarray(cosine) / 0.2, 0.0, 1.0)

    def _axis(self, text: str) -> int:
        if SOMETHING_ELSE.lower() in text:
            return self.dim - 2
        named = max((noun for noun in self._nouns if noun in text), key=len, default=None)
        return self.dim - 1 if named is None else self._nouns.index(named)

    def encode_image(self, rgb: np.ndarray, hfov: float = CameraModel.hfov, window=None) -> View:
        """The true content of the world's latest picture, which ``rgb`` must be."""
        left, top, right, bottom = window or (0, 0, rgb.shape[1], rgb.shape[0])
        counts = self._counts(slice(top, bottom, 2), slice(left, right, 2))
        rows = []
        for first, last in self.REGIONS:
            columns = slice(round(first * counts.shape[1]), round(last * counts.shape[1]))
            pixels = counts[:, columns].sum(axis=(0, 1))
            pixels[pixels < self.MIN_PIXELS] = 0
            pixels[-1] = self.OTHER
            rows.append(np.sqrt(np.append(pixels, 0.0)) / np.sqrt(pixels.sum()))
        middle = np.array([(first + last) / 2 for first, last in self.REGIONS])
        bearings = column_bearings(left + middle * (right - left), rgb.shape[1], hfov)
        features = cv2.resize(counts, self.CELLS[::-1], interpolation=cv2.INTER_AREA)
        return View(np.array(rows, np.float32), bearings, (features.transpose(2, 0, 1),), window)

    def saliency(self, view: View, direction: np.ndarray) -> np.ndarray:
        """Share of each cell's pixels ``(h, w)`` that belong to what ``direction (dim,)`` names."""
        return np.tensordot(np.maximum(direction[:-1], 0), view.features[0], axes=1)

    def _kind(self, thing_id: str) -> int:
        """The axis of what a thing is; of a kind that came into the home later, that of everything else."""
        if thing_id not in self._noun_of:
            self._noun_of[thing_id] = self._world.house.objects[thing_id].model.name.lower()
        noun = self._noun_of[thing_id]
        return self._nouns.index(noun) if noun in self._nouns else self.dim - 2

    def _counts(self, rows: slice, columns: slice) -> np.ndarray:
        """4 for each noun's pixels among every second one of the picture's, else 0: ``(rows, columns, nouns + 1)``."""
        instances = self._world.picture.instances[rows, columns]
        axis = np.array([self._kind(thing) for thing in self._world.object_ids] + [self.dim - 2])  # -1 is no object
        return 4.0 * (axis[instances][..., None] == np.arange(self.dim - 1)).astype(np.float32)
