"""``vlpg eval objectnav``: find things in homes never seen before, by discrete actions, and count as [U] does."""

import argparse
import json
from dataclasses import replace
from pathlib import Path

from firmware_sim.house import HouseError
from models.manifest import ModelError
from tools.eval.objectnav import table
from tools.eval.objectnav.campaign import Plan
from tools.eval.objectnav.planners import PLANNERS, Planner, single_prompts, sub_ensembles
from tools.eval.options import add_options, check, results, some_of
from tools.eval.spread import write
from tools.eval.table import write_csv

SWEEPS = {
    "kappa": {f"kappa {k:g}": replace(PLANNERS["I-FBE2"], off_axis=k) for k in (0.0, 0.001, 0.01, 0.05, 0.2, 1.0)},
    "beta": {f"beta {beta:g}": replace(PLANNERS["I-FBE2"], beta=beta) for beta in (0.0, 0.25, 1.0, 4.0, 16.0)},
    "tie": {f"tie {tie:g}": replace(PLANNERS["I-FBE2"], tie=tie) for tie in (0.0, 0.05, 0.2, 0.4, 0.6, 0.8)},
    "scale": {
        f"{name}, {scale}": replace(PLANNERS[name], calibrated=scale == "calibrated")
        for name in ("I-FBE1", "I-FBE2")
        for scale in ("calibrated", "raw cosine")
    },
}


def planners_of(options) -> dict[str, Planner]:
    """Those that the options ask for. Raises ValueError for one that does not exist."""
    if options.sweep:
        return SWEEPS[options.sweep]
    if options.table == 1:
        ensemble = {name: PLANNERS[name] for name in ("I-FBE1", "I-FBE2")}
        return {**single_prompts(), **ensemble, **sub_ensembles(options.seed)}
    return {name: PLANNERS[name] for name in some_of(PLANNERS, options.planners, "planner")}


def main(arguments: list[str] | None = None) -> None:
    """``vlpg eval objectnav``."""
    parser = argparse.ArgumentParser(prog="vlpg eval objectnav", description=__doc__.split(": ", 1)[1])
    add_options(parser)
    parser.add_argument("--objects", type=int, default=1, metavar="N", help="sought in each home (default: 1)")
    parser.add_argument(
        "--planners", default="all", metavar="P,…", help=f"of table 2: all, or some of {', '.join(PLANNERS)}"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--table", type=int, choices=[1, 2], default=2, help="1: each prompt alone, ensembles; 2: planners (default)"
    )
    what.add_argument("--sweep", choices=list(SWEEPS), help="vary what the paper leaves open")
    what.add_argument("--figure", choices=["qq"], help="whether similarities over prompts are normal, as Fig. 3")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw the table or the figure")
    options = parser.parse_args(arguments)
    check(parser, options)
    if options.figure and options.encoder == "oracle":
        parser.error("the oracle knows words, not wordings; name a model with --encoder")
    if options.figure and (options.out or options.csv or options.ray):
        parser.error("--figure is quick and has no episodes: leave out --out, --csv and --ray")
    try:
        planners = planners_of(options)
    except ValueError as error:
        parser.error(str(error))
    try:
        if options.figure:
            _figure(options)
            return
        found = results(Plan(tuple(planners.items()), options.encoder, options.objects, options.seed), options)
    except (HouseError, ModelError, RuntimeError) as error:
        parser.exit(2, f"vlpg eval objectnav: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "\nvlpg eval objectnav: stopped; with --out, the same command goes on from what is done\n")
    episodes = [episode for result in found for episode in result.episodes]
    print(f"{options.encoder} encoder, {len(found)} homes, seed {options.seed}\n{table.show(episodes)}")
    if options.table == 1 and not options.sweep:
        print(table.show_spread(episodes))
    if options.json:
        write(found, table.rows(episodes), options.json)
    if options.csv:
        write_csv(episodes, table.rows(episodes), options.csv)
    if options.picture:
        table.draw(episodes, options.picture)


def _figure(options) -> None:
    from tools.eval.objectnav.quantiles import draw, normal_straightness, similarities, straightness
    from tools.eval.options import homes_named

    spreads = similarities(homes_named(options.homes), options.encoder, options.objects, options.seed)
    found = {count: (straightness(values), normal_straightness(count)) for count, values in spreads.items()}
    for count, (ours, normal) in found.items():
        print(
            f"{count:3d} prompts: correlation with normal quantiles {ours:.3f}; of samples that are normal {normal:.3f}"
        )
    if options.json:
        figure = [{"prompts": count, "correlation": ours, "normal": normal} for count, (ours, normal) in found.items()]
        options.json.write_text(json.dumps(figure, indent=1) + "\n")
    if options.picture:
        draw(spreads, options.picture)


if __name__ == "__main__":
    main()
