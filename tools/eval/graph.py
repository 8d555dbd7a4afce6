"""``vlpg eval graph``: what closing loops and straightening the graph is worth to a robot that drifts."""

import argparse
from dataclasses import dataclass

import numpy as np

from edge.localization.localizer import Localizer
from edge.missions.map_home import MapHome
from edge.perception.encoder import Encoder
from edge.pose import between, wrap
from firmware_sim.base import BaseConfig
from firmware_sim.home import load_home
from firmware_sim.house import HouseError
from firmware_sim.seed import seed
from firmware_sim.world import World, WorldConfig
from host.pose_graph import optimise
from models.manifest import DEFAULT, ModelError
from tools.eval.options import need_gtsam
from tools.eval.oracle import OracleEncoder
from tools.eval.tour import new_robot, run

# Wheels ten times as uneven as the simulator's own, and five times as slippery, so that a tour of one flat drifts as
# far as one of a larger home would.
DRIFTING = BaseConfig(scale_error=0.04, slip=0.10)


@dataclass(frozen=True, slots=True)
class Straightened:
    """Errors of the nodes of one tour: RMS, m and rad, before and after."""

    home: str
    nodes: int
    loops: int
    raw: tuple[float, float]
    optimised: tuple[float, float]


class DeadReckoning(Localizer):
    """Believes its wheels and nothing else."""

    def update(self, odom, scan, grid):
        self.fits = scan is not None
        return self.pose(odom)


def straighten(home: str, encoder: str, seed: int) -> Straightened:
    """One robot maps ``home``; a second one in the same body sees all it sees, but only counts its wheels' turns."""
    world = World(load_home(home), seed, WorldConfig(base=DRIFTING))
    encoder = OracleEncoder(world) if encoder == "oracle" else Encoder.load(encoder)
    guide, blind = new_robot(world, encoder), new_robot(world, encoder)
    blind.localizer = DeadReckoning()
    mission, truth = MapHome(guide), []
    see, add = guide.perceive, blind.memory.add

    def see_both(observation):
        see(observation)
        blind.perceive(observation)

    def add_and_note(*view, **parts):
        node = add(*view, **parts)
        if node is not None:
            truth.append(between(world.house.start, world.truth))
        return node

    guide.perceive, blind.memory.add = see_both, add_and_note
    run(world, mission)
    ids, edges = np.arange(len(truth)), blind.memory.edges()
    raw = blind.memory.poses(ids)
    ends = np.column_stack([edges.i, edges.j])
    poses, _ = optimise(ids, raw, ends, edges.transforms, edges.information, edges.trusted)
    errors = [_rms(found, np.array(truth)) for found in (raw, poses)]
    return Straightened(world.house.name, len(ids), edges.kinds.count("loop"), *errors)


def _rms(poses: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    position = np.hypot(*(poses - truth)[:, :2].T)
    heading = wrap(poses[:, 2] - truth[:, 2])
    return float(np.sqrt((position**2).mean())), float(np.sqrt((heading**2).mean()))


def main(arguments: list[str] | None = None) -> None:
    """Prints a line for each home."""
    parser = argparse.ArgumentParser(prog="vlpg eval graph", description=__doc__.split(": ", 1)[1])
    everywhere = ["apartment", "cottage", "bungalow"]
    parser.add_argument("homes", nargs="*", default=everywhere, help="names, files, generated:N")
    parser.add_argument("--encoder", default=DEFAULT, metavar="MODEL", help="a model's name, or oracle: true labels")
    parser.add_argument("--seed", type=seed, default=0, help="of every source of noise")
    options = parser.parse_args(arguments)
    need_gtsam(parser)
    print("RMS error of the nodes of a robot that only counts its wheels' turns, before and after straightening")
    print(f"{'home':14} {'nodes':>6} {'loops':>6} {'raw':>18} {'optimised':>18}")
    for home in options.homes:
        try:
            found = straighten(home, options.encoder, options.seed)
        except (HouseError, ModelError) as error:
            parser.exit(2, f"vlpg eval graph: {error}\n")
        except KeyboardInterrupt:
            parser.exit(130, "\nvlpg eval graph: stopped\n")
        raw, after = (f"{m:.3f} m {np.degrees(turn):6.2f} deg" for m, turn in (found.raw, found.optimised))
        print(f"{found.home:14} {found.nodes:6d} {found.loops:6d} {raw:>18} {after:>18}", flush=True)


if __name__ == "__main__":
    main()
