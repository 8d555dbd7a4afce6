"""Stage ``sprites``: every model of the training libraries, cut out, from many directions."""

import zlib
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from tools.assets.catalog import Entry, find_libraries, open_library
from tools.assets.obj_model import load_mesh
from tools.assets.rasterizer import render

# CC-BY 3.0 and Free Art 1.3, used as training data and not shipped. BlendSwap-CC-0 furnishes our homes: it must never
# be named here.
LIBRARIES = ("BlendSwap-CC-BY", "KatorLegaz", "Scopia", "Contributions", "LucaPresidente")
VIEWS = 28  # pictures a model
SIDE = 232  # px, longer side; an object fills at most the height of the tower's input
FRONT = -np.pi / 2  # azimuth of a viewer in front of the model


@dataclass(frozen=True)
class Sprite:
    """One cut-out picture: ``rgba`` (h, w, 4) uint8, at ``scale`` px per metre."""

    rgba: np.ndarray
    scale: float


def render_library(path: Path, folder: Path, views: int = VIEWS) -> None:
    """Write ``folder/<library>/<id>.npz`` for each model of a library; models already there are skipped."""
    library = open_library(path)
    target = folder / path.stem
    target.mkdir(parents=True, exist_ok=True)
    for entry in library:
        file = target / f"{entry.id}.npz"
        if file.exists():
            continue
        mesh = load_mesh(library, entry)
        rng = np.random.default_rng(zlib.crc32(f"{path.stem}/{entry.id}".encode()))
        arrays = {}
        for i in range(views):
            # Two in three from the front half, where furniture along a wall is seen from; the camera is 0.88 m high.
            spread = np.pi / 2 if i % 3 else np.pi
            yaw = FRONT + rng.uniform(-spread, spread)
            pitch = np.radians(rng.uniform(-6, 42))
            view = render(mesh, yaw, pitch, SIDE)
            rgba, _ = _crop(view.rgba)
            arrays[f"png{i}"] = cv2.imencode(".png", cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGRA))[1]
            arrays[f"scale{i}"] = view.scale
        partial = file.with_suffix(".part.npz")
        np.savez(partial, **arrays)
        partial.rename(file)


def load_sprites(folder: Path, entry: Entry) -> list[Sprite]:
    """The sprites of one model, in the order they were rendered."""
    with np.load(folder / entry.library / f"{entry.id}.npz") as file:
        count = sum(name.startswith("png") for name in file.files)
        return [Sprite(_decode(file[f"png{i}"]), float(file[f"scale{i}"])) for i in range(count)]


def training_entries(furniture: Path) -> list[Entry]:
    """Catalog entries of all training libraries in ``furniture``. Raises FileNotFoundError when one is missing."""
    libraries = find_libraries(furniture)
    missing = [name for name in LIBRARIES if name not in libraries]
    if missing:
        raise FileNotFoundError(
            f"{furniture} lacks {', '.join(missing)}: `apt-get install sweethome3d-furniture "
            "sweethome3d-furniture-nonfree`, the latter from Debian's non-free component, or give the folder of both."
        )
    return [entry for name in LIBRARIES for entry in open_library(libraries[name])]


def _decode(png: np.ndarray) -> np.ndarray:
    return cv2.cvtColor(cv2.imdecode(png, cv2.IMREAD_UNCHANGED), cv2.COLOR_BGRA2RGBA)


def _crop(rgba: np.ndarray) -> tuple[np.ndarray, tuple[int, int]]:
    """Without the empty margin, and where the crop starts (x, y). A picture with nothing in it stays as it is."""
    ys, xs = np.nonzero(rgba[..., 3] > 8)
    if not len(xs):
        return rgba, (0, 0)
    return rgba[ys.min() : ys.max() + 1, xs.min() : xs.max() + 1], (int(xs.min()), int(ys.min()))
