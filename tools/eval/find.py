"""``vlpg eval find``: map homes, ask for what is in them by each method, and count what was found and how well."""

import argparse
import os
import sys
from importlib.util import find_spec
from pathlib import Path

from firmware_sim.home import GENERATED
from firmware_sim.house import HOMES, HouseError
from models.manifest import DEFAULT, ModelError
from tools.eval.campaign import HomeResult, Plan, run_homes, write
from tools.eval.disturbance import DISTURBANCES
from tools.eval.methods import METHODS
from tools.eval.reliability import claims_of
from tools.eval.reliability import show as reliability
from tools.eval.table import name_of, show, write_csv
from tools.eval.truth import TRUTHS


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

    Raises ValueError for a name that is not among them.
    """
    named = tuple(known) if text == "all" else tuple(filter(None, text.split(",")))
    for name in named:
        if name not in known:
            raise ValueError(f"there is no {kind} {name}; there are {', '.join(known)}")
    return named


def show_home(result: HomeResult) -> str:
    """One line for each episode of a home."""
    lines = [f"\n{result.home}: {result.mapped}; {show_memory([result])}"]
    for e in result.episodes:
        lines.append(
            f"  {e.noun:24} {name_of(e):30} {'ok' if e.success else '--'} {e.status:13} {e.cause:26}"
            f" {e.duration:6.1f} s {e.distance:5.1f} m {e.pose_error:5.2f} m off"
        )
    return "\n".join(lines)


def show_memory(results: list[HomeResult]) -> str:
    """What the graph weighs against a dense map of the same homes."""
    ours, dense = (sum(getattr(result, name) for result in results) for name in ("memory", "dense"))
    return f"VLPG {ours / 1e6:.2f} MB, a VLMaps grid {dense / 1e6:.0f} MB, {dense / ours:.0f} times as much"


def main(arguments: list[str] | None = None) -> None:
    """``vlpg eval find``."""
    parser = argparse.ArgumentParser(prog="vlpg eval find", description=__doc__.split(": ", 1)[1])
    parser.add_argument(
        "--homes", default="handmade", help="handmade (all of them), generated:0-39, or names, comma-separated"
    )
    parser.add_argument("--encoder", default=DEFAULT, metavar="MODEL", help="a model's name, or oracle: true labels")
    parser.add_argument(
        "--methods", default="vlpg-nav", metavar="M,…", help=f"all, or some of {', '.join(METHODS)} (default: vlpg-nav)"
    )
    parser.add_argument(
        "--objects", type=int, metavar="N", help="ask for N things a home that its tour had in view (default: for all)"
    )
    parser.add_argument(
        "--disturb",
        default="",
        metavar="D,…",
        help=f"also ask after all, or some, of these happened: {', '.join(DISTURBANCES)}",
    )
    parser.add_argument(
        "--truth",
        default="",
        metavar="P,…",
        help=f"also ask with all, or some, of these parts told the truth, one at a time: {', '.join(TRUTHS)}",
    )
    parser.add_argument("--search", action="store_true", help="never say that it is not here; claim the best guess")
    parser.add_argument("--seed", type=int, default=0, help="of every source of noise")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="homes at a time (default: one a core)")
    parser.add_argument("--ray", metavar="ADDRESS", help="run the homes on the Ray cluster there (extra `cluster`)")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="keep each home's result there, and go on from it")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all episodes there")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="the same as a table")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw success and SAE of the methods")
    options = parser.parse_args(arguments)
    try:
        methods = some_of(METHODS, options.methods, "method")
        disturbances = some_of(DISTURBANCES, options.disturb, "disturbance")
        truths = some_of(TRUTHS, options.truth, "part")
    except ValueError as error:
        parser.error(str(error))
    if options.objects is not None and options.objects < 1 or options.jobs < 1:
        parser.error("--objects and --jobs must be at least 1")
    for path in filter(None, (options.json, options.csv, options.picture)):
        if not path.parent.is_dir():
            parser.error(f"there is no folder {path.parent} to write {path.name} into")
    if options.ray and find_spec("ray") is None:
        parser.error("--ray needs Ray; pip install 'vlpg-edge[cluster]'")
    try:
        asked = options.encoder, options.objects, disturbances, truths, options.search, options.seed
        plan = Plan(methods, *asked)
        results = _run(homes_named(options.homes), plan, options)
    except (HouseError, ModelError, RuntimeError) as error:
        parser.exit(2, f"vlpg eval find: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "\nvlpg eval find: stopped; with --out, the same command goes on from what is done\n")
    print("\n".join(map(show_home, results)))
    episodes = [episode for result in results for episode in result.episodes]
    print(f"\n{options.encoder} encoder, {len(results)} homes, seed {options.seed}\n{show(episodes)}")
    print(show_memory(results))
    claims = claims_of([e for e in episodes if name_of(e) == "vlpg-nav"])
    if claims:
        print(f"\nhow far vlpg-nav's confidence can be believed\n{reliability(claims)}")
    if options.json:
        write(results, options.json)
    if options.csv:
        write_csv(episodes, options.csv)
    if options.picture:
        from tools.eval.chart import draw  # late: it brings a plotting library

        draw(episodes, options.picture)


def _run(homes: list[str], plan: Plan, options) -> list[HomeResult]:
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

    results = []
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(file=sys.stderr)) as progress:
        done = run_homes(homes, plan, options.jobs, options.out, options.ray)
        for result in progress.track(done, len(homes), description="homes"):
            right = sum(episode.success for episode in result.episodes)
            progress.console.print(f"{result.home}: {right} of {len(result.episodes)} right")
            results.append(result)
    return sorted(results, key=lambda result: result.home)


if __name__ == "__main__":
    main()
