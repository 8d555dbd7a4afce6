"""The command line of benchmarks that drive a robot about in homes many times."""

import argparse
from collections.abc import Sequence

from firmware_sim.home import load_home
from firmware_sim.house import House, HouseError
from firmware_sim.seed import seed

HANDMADE = ("apartment", "cottage", "bungalow")


def homes_and_seeds(module: str, description: str, runs: int, counted: str) -> tuple[list[House], range]:
    """The homes that the arguments name, and a seed for each of the ``runs``, which are ``counted`` so.

    Ends the program, with a sentence, when the arguments cannot be followed.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m {module}", description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--homes", nargs="+", default=HANDMADE, help="names, files or generated:SEED")
    parser.add_argument("--runs", type=int, default=runs, help=f"{counted} (default: %(default)s)")
    parser.add_argument("--seed", type=seed, default=0, help="of the first run; the next ones count up")
    options = parser.parse_args()
    if options.runs < 1:
        parser.error("--runs must be at least 1")
    return load_homes(parser, options.homes), range(options.seed, options.seed + options.runs)


def load_homes(parser: argparse.ArgumentParser, homes: Sequence[str]) -> list[House]:
    """The homes of these names; ends the program, with a sentence, when there is none of a name."""
    try:
        return [load_home(home) for home in homes]
    except HouseError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
