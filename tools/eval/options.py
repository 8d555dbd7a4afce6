"""What the evaluations over many homes have in common on the command line."""

import argparse
import os
import sys
from importlib.util import find_spec
from pathlib import Path

from firmware_sim.home import GENERATED, load_home
from firmware_sim.house import HOMES, HouseError
from firmware_sim.seed import seed
from models.manifest import DEFAULT
from tools.eval.spread import Plan, run_homes

PICTURES = ".png", ".svg", ".pdf", ".jpg"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Which homes and encoder, where the work is done, and what is written."""
    parser.add_argument(
        "--homes", default="handmade", help="handmade (all of them), generated:0-39, or names, comma-separated"
    )
    parser.add_argument("--encoder", default=DEFAULT, metavar="MODEL", help="a model's name, or oracle: true labels")
    parser.add_argument("--seed", type=seed, default=0, help="of every source of noise")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="homes at a time (default: one a core)")
    parser.add_argument("--ray", metavar="ADDRESS", help="run the homes on the Ray cluster there (extra `cluster`)")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="keep each home's result there, and go on from it")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table and all episodes there")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the episodes there, and the table beside it")


def check(parser: argparse.ArgumentParser, options) -> None:
    """Ends the program, with a sentence, when the options cannot be followed."""
    if options.objects is not None and options.objects < 1 or options.jobs < 1:
        parser.error("--objects and --jobs must be at least 1")
    for path in filter(None, (options.json, options.csv, options.picture)):
        check_folder(parser, path)
    if options.picture and options.picture.suffix not in PICTURES:
        parser.error(f"{options.picture.name}: end it in {', '.join(PICTURES)}")
    if options.out and options.out.exists() and not options.out.is_dir():
        parser.error(f"{options.out} is a file; --out needs a folder")
    if options.ray and find_spec("ray") is None:
        parser.error("--ray needs Ray; pip install '.[cluster]'")


def check_folder(parser: argparse.ArgumentParser, path: Path) -> None:
    """Ends the program, with a sentence, when there is no folder to write ``path`` into."""
    if not path.parent.is_dir():
        parser.error(f"there is no folder {path.parent} to write {path.name} into")


def need_gtsam(parser: argparse.ArgumentParser) -> None:
    """Ends the program, with a sentence, where graphs cannot be straightened."""
    if find_spec("gtsam") is None:
        parser.error("this needs GTSAM; pip install '.[host]'")


def homes_named(text: str) -> list[str]:
    """Homes from "handmade", "generated:A-B", or names, files and "generated:N" separated by commas.

    Raises HouseError when a range is none.
    """
    if text == "handmade":
        return sorted(path.stem for path in HOMES.glob("*.json"))
    homes = []
    for part in text.split(","):
        first, dash, last = part.removeprefix(GENERATED).partition("-")
        if not (part.startswith(GENERATED) and dash):
            homes.append(part)
        elif first.isdecimal() and last.isdecimal() and int(first) <= int(last):
            homes += [f"{GENERATED}{seed}" for seed in range(int(first), int(last) + 1)]
        else:
            raise HouseError(f"{part} is no range of homes; write {GENERATED}0-39")
    return homes


def some_of(known, text: str, kind: str) -> tuple[str, ...]:
    """The ones of ``known`` that ``text`` names, separated by commas, or all of them for "all".

    Raises ValueError for a name that is not among them, or for none at all.
    """
    named = tuple(known) if text == "all" else tuple(filter(None, text.split(",")))
    if not named:
        raise ValueError(f"no {kind} is named; there are {', '.join(known)}")
    for name in named:
        if name not in known:
            raise ValueError(f"there is no {kind} {name}; there are {', '.join(known)}")
    return named


def results(plan: Plan, options) -> list:
    """What the ``plan`` finds in the homes of the ``options``, by home, with a progress bar meanwhile.

    Raises HouseError, ModelError or RuntimeError; KeyboardInterrupt at Ctrl-C.
    """
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

    homes, found = homes_named(options.homes), []
    for home in homes:
        if not home.removeprefix(GENERATED).isdecimal():
            load_home(home)  # that there is no such one is said before hours are spent on the others
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(file=sys.stderr)) as progress:
        done = run_homes(homes, plan, options.jobs, options.out, options.ray, progress.console.print)
        for result in progress.track(done, len(homes), description="homes"):
            right = sum(episode.success for episode in result.episodes)
            progress.console.print(f"{result.home}: {right} of {len(result.episodes)} right")
            found.append(result)
    return sorted(found, key=lambda result: result.home)
