"""``models/<name>/manifest.json``: all that describes an encoder pair. The runtime knows manifests, not names."""

import hashlib
import json
import os
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

DEFAULT = "lite0-minilm"
SHIPPED = Path(__file__).parent


class ModelError(RuntimeError):
    """A model folder is missing, incomplete, damaged or of another version. The message says what to do."""


@dataclass(frozen=True)
class File:
    """One file of a model folder."""

    name: str
    sha256: str
    size: int  # bytes

    def __post_init__(self):
        # Manifests come over the network, too: no name may lead out of the model's folder.
        if not self.name or self.name.startswith(".") or "/" in self.name or "\\" in self.name:
            raise ValueError(f"{self.name!r} is not the plain name of a file")
        if self.name in ("manifest.json", "MODEL_CARD.md") or self.name.endswith(".part"):
            raise ValueError(f"{self.name} cannot be one of the model's files")
        if not isinstance(self.size, int) or not re.fullmatch(r"[0-9a-f]{64}", str(self.sha256)):
            raise ValueError(f"{self.name} lacks a size in bytes and a sha256")


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
    pad_id: int | None = None  # fills prompts up to the context length, for towers that know no other; None: no filling


@dataclass(frozen=True)
class Relevance:
    """Cosine to relevance in [0, 1]: ``sigmoid(slope * cosine + offset)``, fitted where the truth is known."""

    slope: float
    offset: float

    def __call__(self, cosine):
        return 1.0 / (1.0 + np.exp(-(self.slope * np.asarray(cosine, np.float32) + self.offset)))


@dataclass(frozen=True)
class Confidence:
    """Evidence to the probability that a claim is true, a logistic fit on claims whose truth is known.

    By itself it believes the two-prompt score of what is in view, as an encoder without a fit must.
    """

    seen: float = 1.0  # weight of the logit of the score of what is in view
    remembered: float = 0.0  # weight of the logit of the memory's best score there
    offset: float = 0.0

    def __call__(self, seen: float, remembered: float) -> float:
        """From two-prompt scores ([V] Eq. 2) in [0, 1]."""
        return float(1 / (1 + np.exp(-self.seen * logit(seen) - self.remembered * logit(remembered) - self.offset)))


def logit(share: float) -> float:
    """Inverse of the logistic function, finite for 0 and 1 too: scores are not that certain."""
    inner = min(max(share, 1e-4), 1 - 1e-4)
    return float(np.log(inner / (1 - inner)))


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
    confidence: Confidence = Confidence()
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
            raise ModelError(f"{path} cannot be read ({error}); {_remedy(path)}") from None
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
            confidence=Confidence(**raw.get("confidence", {})),
            source=str(raw.get("source", "")),
            licence=str(raw.get("licence", "")),
            measured={str(key): float(value) for key, value in raw.get("measured", {}).items()},
        )

    @property
    def image_files(self) -> tuple[File, ...]:
        """What a robot needs that leaves text to a host: all files but the text tower's."""
        text = self.text.graph, self.text.tokenizer
        return tuple(f for f in self.files if f.name not in text and not f.name.startswith(f"{self.text.graph}."))

    @property
    def has_text(self) -> bool:
        """Whether its text tower is at hand; on a robot that leaves text to a host it is not."""
        return (self.folder / self.text.graph).is_file()

    def verify(self, text: bool = True) -> None:
        """Check every file's presence, size and sha256 (about 0.1 s for 30 MB); without ``text``, not the text tower's.

        Raises:
            ModelError: names the first file that is missing or damaged.
        """
        for file in self.files if text else self.image_files:
            path = self.folder / file.name
            if not path.is_file():
                raise ModelError(f"{path} is missing; {_remedy(self.folder)}")
            if path.stat().st_size != file.size or sha256(path) != file.sha256:
                raise ModelError(f"{path} is damaged (its size or sha256 is not the manifest's); {_remedy(path)}")


def user_folder() -> Path:
    """Where the user's own models are: ``$VLPG_MODELS``, or ``~/.local/share/vlpg/models``."""
    return Path(os.environ.get("VLPG_MODELS") or Path.home() / ".local" / "share" / "vlpg" / "models")


def folders() -> dict[str, Path]:
    """Every model at hand, by name: the shipped ones, then the user's. A shipped name cannot be taken."""
    found = {}
    for home in (SHIPPED, user_folder()):
        for path in sorted(home.glob("[!.]*/manifest.json")):
            found.setdefault(path.parent.name, path.parent)
    return found


def resolve(name: str | Path = DEFAULT) -> Path:
    """Folder of a model: the name of a shipped one or of one of the user's, or a path to a folder.

    Raises:
        ModelError: neither exists; the message lists the names that do.
    """
    folder = folders().get(str(name), Path(name))
    if (folder / "manifest.json").is_file():
        return folder
    raise ModelError(f"There is no model named {name}. Known: {_known()}; or give a folder with a manifest.json.")


def sha256(path: Path) -> str:
    """Of a file, hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _known() -> str:
    return ", ".join(folders()) or "none"


def _remedy(path: Path) -> str:
    if path.is_relative_to(SHIPPED):
        return (
            f"restore it, e.g. git checkout -- {path}"
            if (SHIPPED.parent / ".git").exists()
            else "install the robot again"
        )
    return "restore it, or remove the model and import or pull it again"
