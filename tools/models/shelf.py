"""The user's own models: a folder each in ``models.manifest.user_folder()``, there whole or not at all."""

import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from models.manifest import SHIPPED, ModelError, folders, user_folder

_PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")


def check_new(name: str) -> None:
    """Whether a model may be put on the shelf under ``name``.

    Raises:
        ModelError: the name is taken, or no plain one.
    """
    if not _PLAIN.fullmatch(name):
        raise ModelError(f"{name!r} is no name for a model: use up to 64 letters, digits, dots, dashes, underscores.")
    taken = folders().get(name) or user_folder() / name
    if taken.is_relative_to(SHIPPED):
        raise ModelError(f"The name {name} belongs to a model that is shipped; choose another.")
    if taken.exists():
        raise ModelError(f"There is a model {name} in {taken}; `vlpg models remove {name}` first, or choose a name.")


@contextmanager
def new_model(name: str) -> Iterator[Path]:
    """An empty folder to fill, which becomes the model ``name`` when the block ends; an error leaves nothing behind.

    Raises:
        ModelError: the name is taken, or no plain one.
    """
    check_new(name)
    user_folder().mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=user_folder(), ignore_cleanup_errors=True) as folder:
        yield Path(folder)
        put(Path(folder), name)


def put(folder: Path, name: str) -> Path:
    """Make the finished ``folder``, which lies on the shelf's own file system, the model ``name``; returns its place.

    Raises:
        ModelError: the name was taken in the meantime.
    """
    check_new(name)
    folder.chmod(0o755)
    return folder.rename(user_folder() / name)


def pulling(name: str) -> Path:
    """Where a pull of ``name`` collects its files; what is there outlives an interruption."""
    return user_folder() / f".{name}.part"


def remove(name: str) -> Path:
    """Delete one of the user's models, or what an interrupted pull of it has left; returns where it was.

    Raises:
        ModelError: it is shipped, or not there.
    """
    mine = {known: folder for known, folder in folders().items() if not folder.is_relative_to(SHIPPED)}
    if name in mine:
        # Under another name first: what is half deleted is no model any more.
        doomed = mine[name].with_name(f".{name}-removed")
        shutil.rmtree(doomed, ignore_errors=True)  # what an interrupted removal has left
        shutil.rmtree(mine[name].rename(doomed))
        return mine[name]
    begun = pulling(name)
    if _PLAIN.fullmatch(name) and begun.is_dir():
        shutil.rmtree(begun)
        return begun
    if name in folders():
        raise ModelError(f"{name} is shipped with vlpg and stays; only models of your own can be removed.")
    raise ModelError(f"You have no model named {name} in {user_folder()}. Yours: {', '.join(mine) or 'none'}.")
