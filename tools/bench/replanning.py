"""Time of a replanning step of ObjectNav: ``python -m tools.bench.replanning`` explores homes on one thread.

A step is what the robot does between two actions of [U]'s protocol: it localizes and maps what it has just seen, and
encodes it, updates the relevance, finds the frontiers, chooses one, and plans the way there. [U] states 420 ms for its
own, on a workstation with a GPU; that is another encoder, another map and another machine. Last comes the update of the
relevance alone, by a picture of 640 columns that sees to the end of its range, on a map of 20 x 20 m.
"""

import argparse
import time

import cv2
import numpy as np

from edge.bench.stopwatch import Stopwatch
from edge.camera import CameraModel
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.relevance import RelevanceMap
from edge.observation import LaserScan
from edge.perception.encoder import Encoder
from firmware_sim.home import load_home
from firmware_sim.house import HouseError
from firmware_sim.seed import seed
from models.manifest import DEFAULT, ModelError
from tools.eval.objectnav.campaign import chosen
from tools.eval.objectnav.episode import Run
from tools.eval.objectnav.planners import PLANNERS
from tools.eval.options import homes_named

STAGES = ("localize and map", "encode", "relevance", "frontiers and choice", "plan")


def steps_of(run: Run, watch: Stopwatch) -> list[dict[str, float]]:
    """Seconds by stage, and of the whole ``step``, of each step of an episode in which a frontier was chosen."""
    agent, steps = run.agent, []
    for owner, method, stage in (
        (run.robot, "perceive", STAGES[0]),
        (agent.exploration.relevance, "integrate", STAGES[2]),
        (agent.exploration, "next_frontier", STAGES[3]),
        (agent, "toward", STAGES[4]),
        (agent, "act", "step"),
    ):
        watch.watch(owner, method, stage)
    while not run.done:
        watch.read()  # what went on between the steps
        action = run.choose()
        spent = {stage: sum(calls) for stage, calls in watch.read().items()}
        if run.done:
            break
        if STAGES[3] in spent:
            steps.append(spent)
        run.carry_out(action)
    return steps


SIDE = 20.0  # m
UPDATES = 200


def wide_updates() -> np.ndarray:
    """Seconds ``(UPDATES,)`` that the relevance of an empty hall takes to update, each from another direction."""
    camera, grid = CameraModel(width=640, height=480), OccupancyGrid()
    beams = LaserScan(0.0, np.full(360, SIDE), -np.pi, np.pi / 180, SIDE / 2, np.zeros(3))
    grid.integrate_scan(np.zeros(3), beams)
    relevance, depth = RelevanceMap(), np.full((480, 640), camera.max_depth, np.float32)
    promise, spent = np.linspace(0.3, 0.5, 7), []
    for heading in np.linspace(-np.pi, np.pi, UPDATES):
        started = time.perf_counter()
        relevance.integrate(np.array([0.0, 0.0, heading]), depth, promise, camera, grid)
        spent.append(time.perf_counter() - started)
    return np.array(spent)


def show(steps: list[dict[str, float]]) -> str:
    """Median and 95 % quantile of each stage [ms], and of the whole."""
    lines = [f"{'stage':22} {'p50':>7} {'p95':>7} {'max':>7}  ms, of {len(steps)} steps"]
    for stage in (*STAGES, "step"):
        times = 1000 * np.array([step.get(stage, 0.0) for step in steps])
        p50, p95 = np.quantile(times, (0.5, 0.95))
        lines.append(f"{stage:22} {p50:7.1f} {p95:7.1f} {times.max():7.1f}")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--homes", default="generated:200-204", help="names, files, generated:SEED or generated:A-B")
    parser.add_argument("--encoder", default=DEFAULT, metavar="MODEL", help="a model's name")
    parser.add_argument("--planner", choices=list(PLANNERS), default="I-FBE2")
    parser.add_argument("--seed", type=seed, default=0, help="of all noise")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    watch, steps = Stopwatch(), []
    try:
        encoder = Encoder.load(options.encoder)
        watch.watch(encoder, "encode_image", STAGES[1])
        for home in homes_named(options.homes):
            (noun,) = chosen(load_home(home), 1)
            steps += steps_of(Run(home, noun, PLANNERS[options.planner], encoder, options.seed), watch)
    except (HouseError, ModelError) as error:
        parser.exit(2, f"tools.bench.replanning: {error}\n")
    print(show(steps))
    p50, p95 = 1000 * np.quantile(wide_updates(), (0.5, 0.95))
    print(f"relevance, 640 columns {p50:6.1f} {p95:7.1f}")


if __name__ == "__main__":
    main()
