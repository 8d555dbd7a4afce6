"""``vlpg models pull``: a finished model folder from a web server or a hub, onto the user's shelf."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

from models.manifest import Manifest, ModelError
from tools.models import hub
from tools.models.download import Missing, download, read
from tools.models.shelf import check_new, pulling, put

CARD = "MODEL_CARD.md"

Progress = Callable[[str, int, int], None]  # name of the file, bytes that are there, bytes in all


def pull(source: str, name: str | None = None, progress: Progress = lambda file, done, total: None) -> Manifest:
    """Fetch the model at ``source``, the address of its folder or a hub's ``ORGANISATION/NAME``, as ``name``.

    Every file is checked against the manifest's sha256. When the connection breaks, what has come stays in a hidden
    folder of the shelf and the next call goes on from there; the model appears when it is whole.

    Raises:
        ModelError: unreachable, not a model, damaged, or the name is taken.
    """
    url, token = _address(source)
    try:
        content = read(f"{url}/manifest.json", token)
    except Missing:
        raise ModelError(
            f"There is no vlpg model at {url}: it has no manifest.json; "
            "models of other formats come in with `vlpg models import`."
        ) from None
    fields = _fields(content, url)
    name = name or str(fields.get("name"))
    check_new(name)
    folder = pulling(name)
    folder.mkdir(parents=True, exist_ok=True)
    manifest = _write_manifest(folder, fields | {"name": name}, url)
    for file in manifest.files:
        download(f"{url}/{file.name}", folder, file, token, lambda done, f=file: progress(f.name, done, f.size))
    try:
        (folder / CARD).write_bytes(read(f"{url}/{CARD}", token))
    except Missing:
        pass  # a model without a card still runs
    _clear(folder, {"manifest.json", CARD} | {file.name for file in manifest.files})
    return Manifest.load(put(folder, name))


def _address(source: str) -> tuple[str, str | None]:
    """Where the files are, and the password to send there."""
    if source.startswith(("http://", "https://")):
        return source.rstrip("/").removesuffix("/manifest.json"), None
    repository = hub.Repository.parse(source)
    if repository is None:
        raise ModelError(f"{source} is neither an http(s) address nor a hub's ORGANISATION/NAME.")
    repository.check_online()
    return repository.url(), hub.token()


def _fields(content: bytes, url: str) -> dict:
    try:
        fields = json.loads(content)
    except ValueError:
        fields = None
    if not isinstance(fields, dict):
        raise ModelError(f"{url}/manifest.json is not a vlpg model's manifest.")
    return fields


def _write_manifest(folder: Path, fields: dict, url: str) -> Manifest:
    (folder / "manifest.json").write_text(json.dumps(fields, indent=2) + "\n")
    try:
        manifest = Manifest.load(folder)
    except ModelError:
        shutil.rmtree(folder)
        raise ModelError(f"{url}/manifest.json is not a vlpg model's manifest, or of another version.") from None
    used = {manifest.image.graph, manifest.image.saliency, manifest.text.graph, manifest.text.tokenizer}
    unlisted = used - {file.name for file in manifest.files}
    if unlisted:
        shutil.rmtree(folder)
        raise ModelError(
            f"{url}/manifest.json names {', '.join(sorted(unlisted))}, but does not list it with a sha256."
        )
    return manifest


def _clear(folder: Path, kept: set[str]) -> None:
    """Away with what an earlier, interrupted pull of something else has left."""
    for path in folder.iterdir():
        if path.name not in kept:
            path.unlink()
