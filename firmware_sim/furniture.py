"""The furniture pack: everything the simulator knows about the things that can stand in a house.

The pack is made by tools/assets/furniture.py from public-domain (CC0) models; CREDITS.md beside it names their authors.
Model frame: origin at the centre of the bounding box on its base plane, x to the right (width), y to the back (the
front faces -y), z up.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from firmware_sim.sprites import SpriteSheet

PACK = Path(__file__).parent / "furniture_pack"


class FurnitureError(ValueError):
    """The pack is missing or damaged."""


@dataclass(frozen=True, eq=False)
class FurnitureModel:
    """One kind of thing. Lengths in metres, in the model frame."""

    id: str  # "teddy-bear"
    name: str  # "Teddy bear"
    tags: tuple[str, ...]
    category: str  # the room it belongs to: Bathroom, Bedroom, Kitchen, Living room, Office, Lights, Exterior, ...
    size: tuple[float, float, float]  # width, depth, height
    elevation: float | None  # height at which it hangs on a wall or ceiling; None = it stands
    top: float | None  # height of a surface things can stand on
    footprint: np.ndarray  # (N, 2) convex, counter-clockwise: hull of the part below 1.0 m
    slices: np.ndarray  # (M, 2, 2) outline 0.25 m above the base, M <= 48; M = 0 where there is nothing
    creator: str
    licence: str
    folder: Path = field(repr=False)
    layout: dict = field(repr=False)  # how its sprite sheets are cut, see tools/assets/sprite_sheet.py

    @cached_property
    def sprites(self) -> SpriteSheet:
        """Pictures from many directions, decoded when first used."""
        return SpriteSheet(self.folder / f"{self.id}.webp", self.folder / f"{self.id}.relief.webp", self.layout)


class Furniture(Mapping[str, FurnitureModel]):
    """All models of a pack by id."""

    def __init__(self, models: dict[str, FurnitureModel]):
        self._models = models

    @classmethod
    def load(cls, folder: str | Path = PACK) -> "Furniture":
        """Read the pack in ``folder``. Raises FurnitureError when it is missing or damaged."""
        folder = Path(folder)
        try:
            entries = json.loads((folder / "catalog.json").read_text(encoding="utf-8"))["models"]
            return cls({entry["id"]: _model(folder, entry) for entry in entries})
        except OSError:
            raise FurnitureError(
                f"There is no furniture pack in {folder}; `python -m tools.assets.furniture` makes it."
            ) from None
        except (ValueError, KeyError, TypeError) as error:
            raise FurnitureError(
                f"{folder / 'catalog.json'} is damaged ({error}); restore it or run `python -m tools.assets.furniture`."
            ) from None

    def __getitem__(self, model_id: str) -> FurnitureModel:
        return self._models[model_id]

    def __iter__(self) -> Iterator[str]:
        return iter(self._models)

    def __len__(self) -> int:
        return len(self._models)


def _model(folder: Path, entry: dict) -> FurnitureModel:
    return FurnitureModel(
        id=entry["id"], name=entry["name"], tags=tuple(entry["tags"]), category=entry["category"],
        size=tuple(entry["size"]), elevation=entry["elevation"], top=entry["top"],
        footprint=np.array(entry["footprint"], float).reshape(-1, 2),
        slices=np.array(entry["slices"], float).reshape(-1, 2, 2),
        creator=entry["creator"], licence=entry["licence"], folder=folder, layout=entry["sprites"],
    )  # fmt: skip
