"""Furniture libraries of Sweet Home 3D (.sh3f): a zip of OBJ models and a Java properties file that describes them."""

import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

INSTALLED = Path("/usr/share/sweethome3d/furniture")  # where Debian's sweethome3d-furniture puts the libraries
CATALOG = "PluginFurnitureCatalog.properties"
PROVIDER_TAGS = {"Blend Swap", "Kator Legaz", "Scopia", "Reallusion", "okh"}  # say who made it, not what it is


@dataclass(frozen=True)
class Entry:
    """One piece of furniture as its catalog describes it. Lengths in metres."""

    library: str  # file name without its ending, e.g. "BlendSwap-CC-0"
    id: str  # slug of the catalog's id, e.g. "teddy-bear"
    name: str  # "Teddy bear"
    tags: tuple[str, ...]
    category: str  # the room or kind the catalog files it under
    size: tuple[float, float, float]  # width, depth, height
    elevation: float | None  # height at which it is meant to hang, None = stands on the floor
    drop_on_top: float | None  # height of a surface things can stand on; None = not said, negative = nothing can
    rotation: np.ndarray  # (3, 3) applied to the OBJ coordinates (y up) before scaling to `size`
    door_or_window: bool
    multi_part: bool
    creator: str
    licence: str
    model: str  # path of the OBJ file inside the library


class Library:
    """An open furniture library: iterate it for its entries, `read` files from it."""

    def __init__(self, path: str | Path):
        """Open the .sh3f file at ``path``. Raises ValueError when it is not a furniture library."""
        self.path = Path(path)
        try:
            self._zip = zipfile.ZipFile(self.path)
            text = self._zip.read(CATALOG).decode("latin-1")
        except FileNotFoundError:
            raise ValueError(f"There is no furniture library at {self.path}.") from None
        except (zipfile.BadZipFile, KeyError):
            raise ValueError(f"{self.path} is not a Sweet Home 3D furniture library (.sh3f).") from None
        self._names = {name.lower(): name for name in self._zip.namelist()}
        values = _properties(text)
        self.version = values.get("version", "?")
        self.entries = _entries(self.path.stem, values)

    def __iter__(self) -> Iterator[Entry]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    def names(self) -> list[str]:
        """All files in the library, in lower case."""
        return list(self._names)

    def read(self, name: str) -> bytes:
        """Content of one file, its name compared without case. Raises KeyError when it is not there."""
        return self._zip.read(self._names[str(PurePosixPath(name.lstrip("/"))).lower()])


def open_library(path: str | Path) -> Library:
    """The furniture library (.sh3f) at ``path``; see `Library`."""
    return Library(path)


def find_libraries(folder: str | Path = INSTALLED) -> dict[str, Path]:
    """Libraries in ``folder`` by name without ending. Raises FileNotFoundError when there is none."""
    found = {path.stem: path for path in sorted(Path(folder).glob("*.sh3f"))}
    if not found:
        raise FileNotFoundError(
            f"No furniture libraries (*.sh3f) in {folder}: run `apt-get install sweethome3d-furniture`, "
            "or give the folder that holds them."
        )
    return found


def slug(text: str) -> str:
    """Lower-case words joined by hyphens: "teddyBear" and "Teddy bear" both give "teddy-bear"."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", text)
    return re.sub(r"[^a-z0-9]+", "-", spaced.lower()).strip("-")


def _properties(text: str) -> dict[str, str]:
    """Java properties: comments, escapes and continued lines."""
    text = re.sub(r"\\\r?\n[ \t]*", "", text)
    values = {}
    for line in text.splitlines():
        line = line.strip()
        if not line or line[0] in "#!" or "=" not in line:
            continue
        key, value = line.split("=", 1)
        value = re.sub(r"\\u([0-9a-fA-F]{4})", lambda match: chr(int(match[1], 16)), value)
        values[key.strip()] = re.sub(r"\\(.)", r"\1", value).strip()
    return values


def _entries(library: str, values: dict[str, str]) -> list[Entry]:
    numbers = sorted(int(key[3:]) for key in values if re.fullmatch(r"id#\d+", key))
    entries, taken = [], set()
    for number in numbers:

        def get(field: str, default: str = "", number: int = number) -> str:
            return values.get(f"{field}#{number}", default)

        def metres(field: str, get=get) -> float | None:
            return float(get(field)) / 100 if get(field) else None

        unique = base = slug(get("id").rsplit("#", 1)[-1])
        copies = 2
        while unique in taken:
            unique, copies = f"{base}-{copies}", copies + 1
        taken.add(unique)
        rotation = np.array(get("modelRotation", "1 0 0 0 1 0 0 0 1").split(), float).reshape(3, 3)
        tags = tuple(tag.strip() for tag in get("tags").split(",") if tag.strip() not in PROVIDER_TAGS | {""})
        drop = metres("dropOnTopElevation")
        entries.append(
            Entry(
                library=library, id=unique, name=get("name"), tags=tags, category=get("category"),
                size=(metres("width"), metres("depth"), metres("height")), elevation=metres("elevation"),
                drop_on_top=drop, rotation=rotation, door_or_window=get("doorOrWindow") == "true",
                multi_part=get("multiPartModel") == "true", creator=get("creator"),
                licence=get("license", values.get("license", "")), model=get("model"),
            )
        )  # fmt: skip
    return entries
