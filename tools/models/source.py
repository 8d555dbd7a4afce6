"""What the user names, found: an OpenCLIP model, a folder, or a hub's repository; and who can read it."""

import re
from importlib.util import find_spec
from pathlib import Path

from models.manifest import ModelError
from tools.models.hub import Repository
from tools.models.pair import Pair


def open_source(source: str, checkpoint: Path | None = None) -> Pair:
    """The pair behind ``source``, with its weights loaded.

    - a folder: of Hugging Face's (``config.json``), of OpenCLIP's (``open_clip_config.json``), or with ready graphs;
    - ``ORGANISATION/NAME`` or ``ORGANISATION/NAME@REVISION`` of a hub, whose folder is one of these;
    - an OpenCLIP architecture, as ``NAME@TAG`` with its own weights or ``NAME`` with those of ``checkpoint``.

    Raises:
        ModelError: it is none of these, cannot be had, or the ``import`` extra is not installed.
    """
    folder = Path(source).expanduser()
    repository = None if folder.exists() else Repository.parse(source)
    if checkpoint is not None and (folder.exists() or repository):
        raise ModelError("--checkpoint goes with the name of an OpenCLIP architecture, such as ViT-B-32.")
    if folder.is_file():
        raise ModelError(
            f"{source} is a file; say its OpenCLIP architecture, too: vlpg models import NAME --checkpoint FILE."
        )
    if source.startswith((".", "/", "~")) and not folder.exists():
        raise ModelError(f"There is no folder {source}.")
    try:
        if folder.is_dir():
            return _in_folder(folder, folder.resolve().name)
        if repository is not None:
            if find_spec("torch") is None:  # to be known before a download
                raise ModuleNotFoundError(name="torch")
            return _in_folder(repository.snapshot(), str(repository))
        from tools.models import openclip

        name, _, tag = source.partition("@")
        return openclip.named(name, tag or None, checkpoint)
    except ModuleNotFoundError as error:
        raise ModelError(f"Importing needs {error.name}: pip install '.[import]'.") from None


def _in_folder(folder: Path, source: str) -> Pair:
    licence = licence_of(folder)
    if (folder / "manifest.json").is_file():
        raise ModelError(f"{source} is a vlpg model already; name its folder, or fetch it with `vlpg models pull`.")
    if (folder / "open_clip_config.json").is_file():
        from tools.models import openclip

        return openclip.from_folder(folder, source, licence)
    weights = any(any(folder.glob(kind)) for kind in ("*.safetensors", "*.bin"))
    if not weights and (any(folder.glob("*.onnx")) or any(folder.glob("onnx/*.onnx"))):
        from tools.models import onnx_pair

        return onnx_pair.from_folder(folder, source, licence)
    if (folder / "config.json").is_file():
        from tools.models import huggingface

        return huggingface.from_folder(folder, source, licence)
    raise ModelError(f"{source} has neither config.json, open_clip_config.json nor ONNX graphs: nothing to import.")


def licence_of(folder: Path) -> str:
    """The licence that the folder's README states in its header, as on a hub; empty if it states none."""
    readme = folder / "README.md"
    text = readme.read_text(errors="replace") if readme.is_file() else ""
    header = re.match(r"---\s*\n(.*?)\n---", text, re.DOTALL)
    found = (
        dict(re.findall(r"^(license|license_name):\s*[\"']?([\w.+ -]+?)[\"']?\s*$", header[1], re.MULTILINE))
        if header
        else {}
    )
    return found.get("license_name") or found.get("license", "")
