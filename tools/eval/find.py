"""``vlpg eval find``: map homes, ask for what is in them by each method, and count what was found and how well."""

import argparse
from pathlib import Path

from firmware_sim.house import HouseError
from models.manifest import ModelError
from tools.eval.campaign import HomeResult, Plan
from tools.eval.disturbance import DISTURBANCES
from tools.eval.methods import METHODS
from tools.eval.options import add_options, check, results, some_of
from tools.eval.reliability import claims_of
from tools.eval.reliability import show as reliability
from tools.eval.spread import write
from tools.eval.table import name_of, rows, show, write_csv
from tools.eval.truth import TRUTHS


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
    add_options(parser)
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
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw success and SAE of the methods")
    options = parser.parse_args(arguments)
    try:
        methods = some_of(METHODS, options.methods, "method")
        disturbances = some_of(DISTURBANCES, options.disturb, "disturbance") if options.disturb else ()
        truths = some_of(TRUTHS, options.truth, "part") if options.truth else ()
    except ValueError as error:
        parser.error(str(error))
    check(parser, options)
    try:
        asked = options.encoder, options.objects, disturbances, truths, options.search, options.seed
        found = results(Plan(methods, *asked), options)
    except (HouseError, ModelError, RuntimeError) as error:
        parser.exit(2, f"vlpg eval find: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "\nvlpg eval find: stopped; with --out, the same command goes on from what is done\n")
    print("\n".join(map(show_home, found)))
    episodes = [episode for result in found for episode in result.episodes]
    print(f"\n{options.encoder} encoder, {len(found)} homes, seed {options.seed}\n{show(episodes)}")
    print(show_memory(found))
    claims = claims_of(episodes)
    if claims:
        print(f"\nhow far vlpg-nav's confidence can be believed\n{reliability(claims)}")
    if options.json:
        write(found, rows(episodes), options.json)
    if options.csv:
        write_csv(episodes, rows(episodes), options.csv)
    if options.picture:
        from tools.eval.chart import draw  # late: it brings a plotting library

        draw(episodes, options.picture)


if __name__ == "__main__":
    main()
