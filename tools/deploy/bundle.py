"""One archive with all that a robot is, and the script that installs it; the same inputs give the same bytes."""

import gzip
import hashlib
import io
import json
import re
import tarfile
from dataclasses import dataclass
from pathlib import Path

from edge.budget import allowance
from models.manifest import Manifest
from tools.deploy.target import TOKENIZERS, DeployError, Target, version
from tools.deploy.wheels import fetch, read_lock

ROOT = Path(__file__).parents[2]
# What is written for the board's own shell and service manager.
BOARD = [
    Path(__file__).parent / "board" / name for name in ("install.sh", "release.env", "robot.env", "vlpg-robot.service")
]
CODE = ("edge", "models")


@dataclass(frozen=True)
class BundleConfig:
    """What goes in."""

    target: Target
    model: Manifest
    offload: bool = False  # a host encodes text: no text tower, no tokenizer

    @property
    def name(self) -> str:
        """Of the archive, without its ending, and of the folder in it."""
        return f"vlpg-edge-{version()}-{self.target.name}{'-offload' if self.offload else ''}"


def make(config: BundleConfig, out: Path, cache: Path) -> Path:
    """Write the archive into folder ``out`` and return its path; wheels are kept in ``cache``.

    Raises DeployError, ModelError or OSError, and leaves no half of an archive.
    """
    content = contents(config, cache)
    path = out / f"{config.name}.tar.gz"
    partial = path.with_suffix(".part")
    out.mkdir(parents=True, exist_ok=True)
    try:
        with partial.open("wb") as stream:
            # Wheels are compressed already; the highest level would cost a minute for nothing.
            with gzip.GzipFile(filename="", mode="wb", fileobj=stream, mtime=0, compresslevel=6) as packed:
                pack(content, config.name, packed)
        return partial.rename(path)
    finally:
        partial.unlink(missing_ok=True)


def contents(config: BundleConfig, cache: Path) -> dict[str, bytes]:
    """The files of a bundle by their names in it. Raises DeployError or ModelError."""
    if not re.fullmatch(r"[\w.+-]+", config.model.folder.name):
        raise DeployError(
            f"{config.model.folder.name!r} cannot be a model's folder on a board; name it in letters and digits"
        )
    config.model.verify(text=not config.offload)
    locked = [one for one in read_lock(config.target) if not (config.offload and one.name == TOKENIZERS)]
    content = {f"wheels/{wheel.name}": wheel.read_bytes() for wheel in fetch(config.target, locked, cache)}
    content |= _code() | _model(config) | _board(config)
    about = {
        "version": version(),
        "machine": config.target.machine,
        "python": config.target.python,
        "model": config.model.name,
        "digest": config.model.digest,
        "offload": config.offload,
    }
    content["about.json"] = (json.dumps(about, indent=1) + "\n").encode()
    content["files.sha256"] = _sums(content)
    content["release"] = f"{hashlib.sha256(content['files.sha256']).hexdigest()[:12]}\n".encode()
    return content


def pack(content: dict[str, bytes], top: str, stream) -> None:
    """Write files as a tar archive, below the folder ``top``.

    Sorted, without times, owners and the archiver's own name: nothing but the content makes a difference.
    """
    with tarfile.open(fileobj=stream, mode="w|", format=tarfile.USTAR_FORMAT) as archive:
        for name in sorted(content):
            member = tarfile.TarInfo(f"{top}/{name}")
            member.size = len(content[name])
            member.mode = 0o755 if name.endswith(".sh") else 0o644
            archive.addfile(member, io.BytesIO(content[name]))


def _code() -> dict[str, bytes]:
    files = [ROOT / "LICENSE", *(file for folder in CODE for file in (ROOT / folder).rglob("*.py"))]
    return {f"app/{file.relative_to(ROOT)}": file.read_bytes() for file in files}


def _model(config: BundleConfig) -> dict[str, bytes]:
    files = config.model.image_files if config.offload else config.model.files
    names = [file.name for file in files] + ["manifest.json"]
    names += ["MODEL_CARD.md"] if (config.model.folder / "MODEL_CARD.md").is_file() else []  # licences and credits
    folder = f"app/models/{config.model.folder.name}"
    return {f"{folder}/{name}": (config.model.folder / name).read_bytes() for name in names}


def _board(config: BundleConfig) -> dict[str, bytes]:
    """The script, the unit and the settings, with what depends on the bundle filled in."""
    words = {
        "@PYTHON@": config.target.python,
        "@MACHINE@": config.target.machine,
        "@MODEL@": config.model.folder.name,
        "@OFFLOAD@": "host" if config.offload else "auto",
        "@MEMORY@": f"{1e6 * allowance(text=not config.offload):.0f}",
    }
    found = {}
    for file in BOARD:
        text = file.read_text()
        for word, value in words.items():
            text = text.replace(word, value)
        found[file.name] = text.encode()
    return found


def _sums(content: dict[str, bytes]) -> bytes:
    """As ``sha256sum`` writes and checks them."""
    return "".join(f"{hashlib.sha256(content[name]).hexdigest()}  {name}\n" for name in sorted(content)).encode()
