"""``models/<name>/manifest.json``: all that describes an encoder pair. The runtime knows manifests, not names."""

import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

DEFAULT = "lite0-minilm"
_HOME = Path(__file__).parent


class ModelError(RuntimeError):
    """A model folder is missing, incomplete, damaged or of another version. The message says what to do."""


@dataclass(frozen=True)
class File:
    """One file of a model folder."""

    name: str
    sha256: str
    size: int  # bytes


@dataclass(frozen=True)
class Image:
    """How a picture becomes the image tower's input: stretch to ``height`` x ``width``, scale to 0..1, normalize."""

    graph: str
    saliency: str  # graph: the image graph's maps and a text direction to a Grad-CAM map
    height: int  # px
    width: int  # px
    mean: tuple[float, float, float]
    std: tuple[float, float, float]
    regions: tuple[tuple[float, float], ...]  # left and right edge of each region's columns, as shares of the width


@dataclass(frozen=True)
class Text:
    """How a prompt becomes the text tower's input."""

    graph: str
    tokenizer: str  # a ``tokenizers`` JSON file
    context_length: int  # tokens; longer prompts are cut


@dataclass(frozen=True)
class Relevance:
    """Cosine to relevance in [0, 1]: ``sigmoid(slope * cosine + offset)``, fitted where the truth is known."""

    slope: float
    offset: float

    def __call__(self, cosine):
        return 1.0 / (1.0 + np.exp(-(self.slope * np.asarray(cosine, np.float32) + self.offset)))


@dataclass(frozen=True)
class Manifest:
    """A checked manifest.

    ``digest`` (sha256, hex) names exactly these weights: a store made with one digest answers no other encoder.
    """

    folder: Path
    name: str
    digest: str
    dim: int
    logit_scale: float
    image: Image
    text: Text
    relevance: Relevance
    files: tuple[File, ...]
    source: str = ""  # where the weights come from
    licence: str = ""  # of the weights
    measured: dict[str, float] = field(default_factory=dict)  # what was measured when the model was made

    @classmethod
    def load(cls, folder: Path) -> "Manifest":
        """Read ``folder/manifest.json``.

        Raises:
            ModelError: no such folder, no manifest in it, or one that cannot be read.
        """
        path = Path(folder) / "manifest.json"
        try:
            raw = json.loads(path.read_text())
        except FileNotFoundError:
            raise ModelError(f"There is no model in {folder}: it has no manifest.json. Known: {_known()}.") from None
        except (OSError, ValueError) as error:
            raise ModelError(f"{path} cannot be read ({error}); restore it, e.g. git checkout -- {path}") from None
        try:
            return cls._parse(Path(folder), raw)
        except (KeyError, TypeError, ValueError) as error:
            raise ModelError(f"{path} lacks or misstates a field ({error}); it was made for another version.") from None

    @classmethod
    def _parse(cls, folder: Path, raw: dict) -> "Manifest":
        files = tuple(File(**entry) for entry in raw["files"])
        image = raw["image"]
        sequences = {"mean": tuple(image["mean"]), "std": tuple(image["std"])}
        regions = {"regions": tuple((float(a), float(b)) for a, b in image["regions"])}
        digest = hashlib.sha256("".join(f"{f.name} {f.sha256}\n" for f in files).encode()).hexdigest()
        return cls(
            folder=folder,
            name=raw["name"],
            digest=digest,
            dim=int(raw["dim"]),
            logit_scale=float(raw["logit_scale"]),
            image=Image(**(image | sequences | regions)),
            text=Text(**raw["text"]),
            relevance=Relevance(**raw["relevance"]),
            files=files,
            source=str(raw.get("source", "")),
            licence=str(raw.get("licence", "")),
            measured=dict(raw.get("measured", {})),
        )

    def verify(self) -> None:
        """Check every file's presence, size and sha256 (about 0.1 s for 30 MB).

        Raises:
            ModelError: names the first file that is missing or damaged.
        """
        for file in self.files:
            path = self.folder / file.name
            if not path.is_file():
                raise ModelError(f"{path} is missing; restore the folder, e.g. git checkout -- {self.folder}")
            if path.stat().st_size != file.size or _sha256(path) != file.sha256:
                raise ModelError(
                    f"{path} is damaged (its size or sha256 is not the manifest's); "
                    f"restore it, e.g. git checkout -- {path}"
                )


def resolve(name: str | Path = DEFAULT) -> Path:
    """Folder of a model: a path to a folder, or the name of one beside this file.

    Raises:
        ModelError: neither exists; the message lists the names that do.
    """
    for folder in (_HOME / name, Path(name)):
        if (folder / "manifest.json").is_file():
            return folder
    raise ModelError(f"There is no model named {name}. Known: {_known()}; or give a folder with a manifest.json.")


def _known() -> str:
    return ", ".join(sorted(path.parent.name for path in _HOME.glob("*/manifest.json"))) or "none"


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
