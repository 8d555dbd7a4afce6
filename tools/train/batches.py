"""Batches of cached scenes: middle maps, windows of them, and what each window shows."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
import torch

from tools.train.features import Features

DEEP = 7, 9  # cells of the deep map; windows fall on its grid, so that both maps can be pooled over them
SEEN = 0.008  # share of a window that an object must cover to be named
HIDDEN = 0.3  # an object less visible than this share is neither named nor denied
SMALLEST = 0.002  # share of the picture that an object must cover to be pointed at


@dataclass(frozen=True)
class Batch:
    """B scenes with W windows each and S sightings of M models.

    ``middle`` (B, 112, 14, 18); ``logits`` (B, R, 1000) of the first R windows; ``windows`` (B, W, 7, 9) 0 or 1;
    ``named`` and ``doubtful`` (B, W, M) bool; of what can be pointed at, ``scene`` (P,), ``model`` (P,) and
    ``presence`` (S, 14, 18), ``shown_in`` (S,) and ``shown`` (S,) of everything in view.
    """

    middle: torch.Tensor
    logits: torch.Tensor
    windows: torch.Tensor
    named: torch.Tensor
    doubtful: torch.Tensor
    scene: torch.Tensor
    model: torch.Tensor
    presence: torch.Tensor
    shown_in: torch.Tensor
    shown: torch.Tensor

    def to(self, device: torch.device) -> "Batch":
        return Batch(*(getattr(self, field.name).to(device) for field in fields(self)))


class Batches:
    """Draws batches of ``size`` scenes without end, mirrored half of the time; ``regions`` as the robot's."""

    def __init__(self, features: Features, regions, models: int, size: int, extra: int, seed: int):
        self._features, self._models, self._size, self._extra = features, models, size, extra
        self._regions = [(round(a * DEEP[1]), round(b * DEEP[1])) for a, b in regions]
        self._rng = np.random.default_rng(seed)
        order = np.argsort(features.scene, kind="stable")
        self._sightings = np.split(order, np.searchsorted(features.scene[order], np.arange(1, len(features.middle))))

    def __iter__(self) -> Iterator[Batch]:
        count = len(self._features.middle)
        while True:
            order = self._rng.permutation(count)
            for start in range(0, count - self._size + 1, self._size):
                yield self._batch(order[start : start + self._size])

    def _batch(self, scenes: np.ndarray) -> Batch:
        f = self._features
        sightings = np.concatenate([self._sightings[scene] for scene in scenes])
        place = np.repeat(np.arange(len(scenes)), [len(self._sightings[scene]) for scene in scenes])
        middle = torch.from_numpy(f.middle[scenes]).float()
        logits = torch.from_numpy(f.logits[scenes]).float()
        presence = torch.from_numpy(f.presence[sightings]).float()
        model, visible = torch.from_numpy(f.model[sightings]), torch.from_numpy(f.visible[sightings])
        windows = torch.from_numpy(np.stack([self._windows() for _ in scenes])).float()
        if self._rng.random() < 0.5:
            middle, presence = middle.flip(3), presence.flip(2)
            logits = logits[:, self._mirrored()]
        in_scene = torch.from_numpy(place)
        fine = windows.repeat_interleave(2, 2).repeat_interleave(2, 3)
        share = torch.einsum("sxy,swxy->sw", presence, fine[in_scene]) / fine[in_scene].sum((2, 3))
        shows = (share > SEEN) & (visible > HIDDEN)[:, None]
        named = torch.zeros(len(scenes), windows.shape[1], self._models, dtype=torch.bool)
        doubtful = named.clone()
        for table, cells in ((named, shows), (doubtful, (share > 0) & ~shows)):
            sighting, window = torch.nonzero(cells, as_tuple=True)
            table[in_scene[sighting], window, model[sighting]] = True
        point = (presence.mean((1, 2)) > SMALLEST) & (visible > HIDDEN)
        return Batch(
            middle, logits, windows, named, doubtful & ~named, in_scene[point], model[point], presence, in_scene, model
        )

    def _windows(self) -> np.ndarray:
        """The regions of the run time, then some of any size from 3 x 3 cells."""
        rng = self._rng
        masks = np.zeros((len(self._regions) + self._extra, *DEEP), bool)
        for mask, (first, last) in zip(masks, self._regions):
            mask[:, first:last] = True
        for mask in masks[len(self._regions) :]:
            top, left = rng.integers(DEEP[0] - 2), rng.integers(DEEP[1] - 2)
            mask[top : rng.integers(top + 3, DEEP[0] + 1), left : rng.integers(left + 3, DEEP[1] + 1)] = True
        return masks

    def _mirrored(self) -> list[int]:
        """Which region each region becomes in a mirror."""
        return [self._regions.index((DEEP[1] - last, DEEP[1] - first)) for first, last in self._regions]
