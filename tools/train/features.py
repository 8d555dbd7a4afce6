"""Stage ``features``: draw scenes and keep what the frozen front of the trunk sees in them, in chunks that resume.

The front is three quarters of the cost of a training step and does not change, so it runs once a scene.
"""

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.assets.catalog import Entry
from tools.train.scenes import Scene, SceneMaker
from tools.train.sprites import load_sprites
from tools.train.words import noun

CHUNK = 500  # scenes a file
SHOWN = 0.004, 0.4  # share of the picture and of the object itself that make a view truly show it


@dataclass(frozen=True)
class Features:
    """N scenes with K model sightings in all.

    ``middle`` (N, 112, 14, 18) float16: the trunk's middle map; ``logits`` (N, R, 1000) float16: what ImageNet's own
    network says of the picture and its regions; ``scene`` (K,) scene of each sighting; ``model`` (K,) index into the
    entries; ``presence`` (K, 14, 18) float16 share of each cell; ``visible`` (K,) share of the model left in view.
    """

    middle: np.ndarray
    logits: np.ndarray
    scene: np.ndarray
    model: np.ndarray
    presence: np.ndarray
    visible: np.ndarray

    @classmethod
    def load(cls, files: list[Path]) -> "Features":
        parts = [dict(np.load(file)) for file in files]
        offset = np.cumsum([0, *(len(part["middle"]) for part in parts)])
        for part, start in zip(parts, offset):
            part["scene"] = part["scene"] + start
        return cls(**{name: np.concatenate([part.pop(name) for part in parts]) for name in list(parts[0])})


def is_validation(entry: Entry) -> bool:
    """Held out of training while choosing how to train: one noun in nine, and of the others one model in sixteen."""
    by_noun, by_model = zlib.crc32(noun(entry).encode()), zlib.crc32(f"{entry.library}/{entry.id}".encode())
    return by_noun % 9 == 0 or by_model % 16 == 0


def is_close_up(scene: np.ndarray) -> np.ndarray:
    """Whether scenes of that number are close-ups: eight of every twenty."""
    return scene % CHUNK % 20 < 8


def make_chunks(
    entries: list[Entry], use: np.ndarray, sprites: Path, see: Callable[[np.ndarray], tuple], folder: Path, count: int,
) -> None:  # fmt: skip
    """Write ``count`` chunks of scenes of ``entries[use]`` into ``folder``; those already there stay.

    ``see`` maps a picture to its middle map (112, 14, 18) and logits (R, 1000).
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{k:03d}.npz" for k in range(count)]
    missing = [k for k, file in enumerate(files) if not file.exists()]
    if not missing:
        return
    chosen = [entries[i] for i in use]
    cutouts = [load_sprites(sprites, entry) for entry in chosen]
    for k in missing:
        maker = SceneMaker(chosen, cutouts, seed=zlib.crc32(f"{folder.name}/{k}".encode()))
        scenes = [_draw(maker, len(chosen), k * CHUNK + i) for i in range(CHUNK)]
        seen = [see(scene.rgb) for scene in scenes]
        partial = files[k].with_suffix(".part.npz")
        np.savez(
            partial,
            middle=np.stack([middle for middle, _ in seen]).astype(np.float16),
            logits=np.stack([logits for _, logits in seen]).astype(np.float16),
            scene=np.repeat(np.arange(CHUNK), [len(scene.models) for scene in scenes]),
            model=use[np.concatenate([scene.models for scene in scenes])],
            presence=np.concatenate([scene.presence for scene in scenes]).astype(np.float16),
            visible=np.concatenate([scene.visible for scene in scenes]),
        )
        partial.rename(files[k])


def _draw(maker: SceneMaker, models: int, number: int) -> Scene:
    """Of twenty scenes, eight close-ups (every model in turn), eleven views of one to six models, one empty room."""
    kind = number % 20
    if kind < 8:
        return maker.close_up((number // 20 * 8 + kind) % models)
    return maker.view(1 + (kind + number // 20) % 6) if kind < 19 else maker.empty()
