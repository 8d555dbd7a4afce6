"""``vlpg eval find``: map homes, ask for everything in them, and count what was found and how well it was centred."""

import argparse
import json
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from math import degrees, radians
from pathlib import Path

import numpy as np

from edge.memory.store import Vlpg
from edge.missions.find_object import FindObject
from edge.missions.map_home import HomeMapped, MapHome
from edge.perception.encoder import Encoder
from edge.perception.prompts import Target
from edge.pose import between
from edge.robot import Robot
from firmware_sim.house import HOMES, House
from firmware_sim.world import World
from tools.eval.judge import judge, sae
from tools.eval.oracle import OracleEncoder

# What the camera, 0.88 m high, can see: whatever stands lower than the top of its picture 1 m away.
HIGHEST = 1.5  # m


@dataclass(frozen=True, slots=True)
class Episode:
    """One question in one home."""

    noun: str
    status: str  # what the robot says
    success: bool  # what is true: it says found, and the object is in view
    in_view: bool
    angular_error: float  # rad; NaN when the home has no such object
    duration: float  # s, simulated
    distance: float  # m
    contacts: int  # collisions
    pose_error: float  # m, of the robot's own pose at the end


@dataclass(frozen=True, slots=True)
class HomeResult:
    """All questions in one home."""

    home: str
    seed: int
    encoder: str
    mapped: HomeMapped
    episodes: list[Episode]

    @property
    def success(self) -> float:
        """Share of successful episodes."""
        return sum(episode.success for episode in self.episodes) / len(self.episodes)

    @property
    def sae(self) -> float:
        """Success weighted by angular error."""
        return sae(*zip(*((episode.success, episode.angular_error) for episode in self.episodes)))


def nouns(house: House) -> list[str]:
    """Names of the objects that stand on the floor or on furniture at a height that the camera sees."""
    return sorted({thing.model.name.lower() for thing in house.objects.values() if thing.elevation < HIGHEST})


def run_home(home: str, encoder_name: str, seed: int, every: int = 1) -> HomeResult:
    """Map one home and ask for ``every`` so many-th of its nouns, each from where the last one ended."""
    house = House.load(home)
    world = World(house, seed)
    encoder = OracleEncoder(world) if encoder_name == "oracle" else Encoder.load()
    robot = Robot(encoder, Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim), world.config.camera_model)
    mapping = MapHome(robot)
    run(world, mapping)
    episodes = []
    for noun in nouns(house)[::every]:
        episodes.append(ask(world, robot, noun, seed))
        print(f"{home}: {noun}: {episodes[-1].status}, {_truth(episodes[-1])}", file=sys.stderr, flush=True)
    return HomeResult(house.name, seed, encoder.name, mapping.outcome, episodes)


def ask(world: World, robot: Robot, noun: str, seed: int) -> Episode:
    """One episode, judged where the robot comes to rest."""
    contacts = world.contacts
    mission = FindObject(robot, Target.of(noun, robot.encoder), seed=seed)
    run(world, mission)
    outcome, verdict = mission.outcome, judge(world, noun)
    return Episode(
        noun,
        outcome.status,
        outcome.status == "found" and verdict.in_view,
        verdict.in_view,
        verdict.angular_error,
        outcome.duration,
        outcome.distance,
        world.contacts - contacts,
        float(np.hypot(*between(robot.pose, between(world.house.start, world.truth))[:2])),
    )


def run(world: World, mission) -> None:
    """Lock-step until the mission is done and the robot stands still."""
    observation = world.step(None)
    while not mission.done or abs(observation.twist).max() > 0.02:
        observation = world.step(mission.step(observation))


def run_homes(homes: list[str], encoder_name: str, seed: int, every: int, jobs: int) -> Iterator[HomeResult]:
    """Results as they come, from ``jobs`` processes."""
    with ProcessPoolExecutor(jobs) as pool:
        futures = [pool.submit(run_home, home, encoder_name, seed, every) for home in homes]
        for future in as_completed(futures):
            yield future.result()


def show(results: list[HomeResult]) -> None:
    """Print each episode, each home, and all together."""
    for result in results:
        print(f"\n{result.home}, {result.encoder} encoder, seed {result.seed}: {result.mapped}")
        for e in result.episodes:
            print(
                f"  {e.noun:24s} {'ok' if e.success else '--':3s} {e.status:14s} {_truth(e):12s}"
                f" {degrees(e.angular_error):6.1f} deg {e.duration:6.1f} s {e.distance:5.1f} m {e.pose_error:5.2f} off"
            )
    print(f"\n{'home':14s} {'objects':>7s} {'success':>8s} {'SAE':>5s} {'claims right':>13s} {'median error':>13s}")
    for result in results:
        print(_row(result.home, result.episodes))
    print(_row("all", [episode for result in results for episode in result.episodes]))


def _truth(episode: Episode) -> str:
    return "in view" if episode.in_view else "not in view"


def _row(name: str, episodes: list[Episode]) -> str:
    claims = [episode for episode in episodes if episode.status == "found"]
    right = sorted(episode.angular_error for episode in claims if episode.success)
    median = right[len(right) // 2] if right else radians(180)
    successes = [episode.success for episode in episodes]
    weighted = sae(successes, [episode.angular_error for episode in episodes])
    return (
        f"{name:14s} {len(episodes):7d} {sum(successes) / len(episodes):8.1%} {weighted:5.2f}"
        f" {f'{len(right)} of {len(claims)}':>13s} {degrees(median):9.1f} deg"
    )


def main(arguments: list[str] | None = None) -> None:
    """``vlpg eval find``."""
    parser = argparse.ArgumentParser(prog="vlpg eval find", description=__doc__.split(": ", 1)[1])
    parser.add_argument("--homes", default="handmade", help="'handmade' (all of them), or names, comma-separated")
    parser.add_argument("--encoder", choices=["shipped", "oracle"], default="shipped")
    parser.add_argument("--seed", type=int, default=0, help="of every source of noise")
    parser.add_argument(
        "--every", type=int, default=1, metavar="N", help="ask for every N-th object only: a quick look"
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="homes at a time (default: one a core)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all episodes there, too")
    options = parser.parse_args(arguments)
    if options.every < 1:
        parser.error("--every must be at least 1")
    if options.homes == "handmade":
        homes = sorted(path.stem for path in HOMES.glob("*.json"))
    else:
        homes = options.homes.split(",")
    results = []
    for result in run_homes(homes, options.encoder, options.seed, options.every, options.jobs):
        print(f"{result.home}: {result.success:.1%} of {len(result.episodes)} found", flush=True)
        results.append(result)
    results.sort(key=lambda result: homes.index(result.home))
    show(results)
    if options.json:
        options.json.write_text(json.dumps([asdict(result) for result in results], indent=1))


if __name__ == "__main__":
    main()
