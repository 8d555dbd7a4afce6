"""What the user sees of an import or a pull."""

import logging
import os
import warnings
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TransferSpeedColumn

from models.manifest import Manifest, ModelError
from tools.models.pull import pull
from tools.models.shelf import check_new


def import_model(source: str, name: str, checkpoint: Path | None) -> None:
    """Import and say step by step what is done. Raises ModelError or OSError."""
    check_new(name)  # before minutes of work
    # The frameworks' own chatter; what matters is said here, in a sentence.
    os.environ.setdefault("TRANSFORMERS_VERBOSITY", "error")
    logging.disable(logging.WARNING)
    warnings.simplefilter("ignore")
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    from tools.models.source import open_source

    pair = open_source(source, checkpoint)
    try:
        from tools.models.importing import import_pair
    except ModuleNotFoundError as error:
        raise ModelError(f"Importing needs {error.name}: pip install '.[import]'.") from None
    console.print(f"{pair.source}: {pair.kind}, {pair.height} x {pair.width} px")
    _summary(import_pair(pair, name, console.print))


def pull_model(source: str, name: str | None) -> None:
    """Pull with a progress bar. Raises ModelError or OSError."""
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    columns = TextColumn("{task.description}"), BarColumn(bar_width=30), DownloadColumn(), TransferSpeedColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:
        tasks = {}

        def progress(file, done, total):
            if file not in tasks:
                tasks[file] = bars.add_task(file, total=total)
            bars.update(tasks[file], completed=done)

        manifest = pull(source, name, progress)
    _summary(manifest)


def _summary(manifest: Manifest) -> None:
    size = sum(file.size for file in manifest.files) / 1e6
    print(f"{manifest.name}: {size:.1f} MB in {manifest.folder}; use it with --model {manifest.name}")
