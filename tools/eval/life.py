"""``vlpg eval life``: a home changes, its robot tours it again; does the memory answer with what is true now?"""

import argparse
import json
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from edge.localization.loop_closure import bent
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg, VlpgConfig
from edge.missions.find_object import FindObject
from edge.missions.map_home import MapHome
from edge.perception.encoder import Encoder
from edge.perception.prompts import Target
from edge.pose import between, compose
from edge.robot import Robot
from firmware_sim.home import load_home
from firmware_sim.house import House, HouseError, pack
from firmware_sim.seed import seed
from firmware_sim.world import World, WorldConfig
from host.pose_graph import optimise
from models.manifest import DEFAULT, ModelError
from tools.eval.changes import Household
from tools.eval.judge import judge
from tools.eval.options import check_folder, homes_named, need_gtsam
from tools.eval.oracle import OracleEncoder
from tools.eval.tour import names_in_view, nouns, run

KINDS = ("unchanged", "moved", "added", "removed")


@dataclass(frozen=True, slots=True)
class Answer:
    """What the memory says where a thing is, and the truth. Nobody drives: a camera is put at the viewpoint."""

    noun: str
    kind: str  # one of KINDS: what has become of the thing since the first tour
    toured: bool  # in view on a tour since then
    remembered: bool  # the memory claims to have seen it
    right: bool  # the best viewpoint shows it, or, for what was removed, nothing is claimed
    among: bool  # one of the viewpoints that a search would try shows it
    stale: bool  # claimed, and the best viewpoint shows where it once was, and does not show it


@dataclass(frozen=True, slots=True)
class Visit:
    """One tour of a home, and what the memory is like after it."""

    home: str
    tour: int  # from 1
    complete: bool
    duration: float  # s, simulated
    answering: int  # nodes
    nodes: int  # in the file, superseded ones too
    limit: int  # of those that answer
    ram: int  # bytes of vectors and poses
    disk: int  # bytes of the file, pictures and map included
    error: tuple[float, float]  # m, RMS of the nodes' positions, before and after straightening
    answers: list[Answer]


class Life:
    """A home and its robot, which is switched on for a tour and off again; its memory stays in a file."""

    def __init__(self, home: str, encoder: str, tours: int, changes: int, seed: int, limit: int, folder: Path):
        """Between two of the ``tours``, ``changes`` things are moved, as many removed and as many added.

        ``limit``: of the nodes that answer. ``folder`` gets the memory.
        """
        self.household = Household(load_home(home), np.random.default_rng(seed))
        self.arriving = self.household.newcomers(changes * (tours - 1))
        self.tours, self.changes, self.seed = tours, changes, seed
        self.path, self.config = folder / "home.vlpg", VlpgConfig(limit=limit)
        self.encoder = None if encoder == "oracle" else Encoder.load(encoder)
        self.houses: list[House] = []  # as it was at each tour so far
        self.seen: set[str] = set()  # nouns in view on some tour since they stand where they do
        self.truth: dict[int, np.ndarray] = {}  # of each node, (3,) seen from the dock

    def visits(self) -> Iterator[Visit]:
        """One for each tour."""
        for tour in range(self.tours):
            if tour:
                self.seen -= self.household.change(self.arriving[(tour - 1) * self.changes : tour * self.changes])
            yield self.visit()

    def visit(self) -> Visit:
        """Switch on at the dock, tour, straighten the graph as a host would, ask for everything, switch off."""
        house = self.household.house
        self.houses.append(House.from_dict(house.to_dict()))
        world = World(house, self.seed + len(self.houses) - 1)
        encoder = self.encoder or OracleEncoder(world, self.vocabulary())
        with Vlpg.open(self.path, encoder.name, encoder.digest, encoder.dim, self.config) as memory:
            robot = Robot(encoder, memory, world.config.camera_model)
            if (saved := memory.load_map()) is not None:
                robot.grid = OccupancyGrid.from_bytes(saved)
            self.note_truth(world, memory)
            mission = MapHome(robot)
            run(world, mission, lambda: self.seen.update(names_in_view(world)))
            before = self.error(memory)
            straighten(robot)
            memory.save_map(robot.grid.to_bytes())
            tour = mission.outcome
            return Visit(
                home=house.name,
                tour=len(self.houses),
                complete=tour.complete,
                duration=tour.duration,
                answering=len(memory),
                nodes=len(memory.held),
                limit=memory.config.limit,
                ram=memory.nbytes,
                disk=sum(file.stat().st_size for file in self.path.parent.iterdir()),
                error=(before, self.error(memory)),
                answers=[self.ask(robot, noun) for noun in sorted(self.vocabulary() - self.still_away())],
            )

    def vocabulary(self) -> set[str]:
        """Nouns of all that is or ever will be in the home, where the camera sees it."""
        first = self.houses[0]
        return {pack()[model].name.lower() for model in self.arriving}.union(nouns(first))

    def still_away(self) -> set[str]:
        """Nouns of what has not arrived yet."""
        return {pack()[model].name.lower() for model in self.arriving} - self.household.added

    def note_truth(self, world: World, memory: Vlpg) -> None:
        """From now on, keep where the robot really was at each new node."""
        add = memory.add

        def add_and_note(*view, **parts):
            node = add(*view, **parts)
            if node is not None:
                self.truth[node] = between(world.house.start, world.truth)
            return node

        memory.add = add_and_note

    def error(self, memory: Vlpg) -> float:
        """RMS [m] of the positions of the nodes that answer."""
        off = memory.poses(memory.ids) - [self.truth[node] for node in memory.ids.tolist()]
        return float(np.sqrt((off[:, :2] ** 2).sum(axis=1).mean()))

    def ask(self, robot: Robot, noun: str) -> Answer:
        """Ask the memory for ``noun``, and look from where it says that the thing is best seen."""
        mission = FindObject(robot, Target.of(noun, robot.encoder))
        mission.hypotheses = mission.recall()
        house = self.household.house
        views = [compose(house.start, hypothesis.pose) for hypothesis in mission.hypotheses]
        views = views[: mission.config.hypotheses]
        claimed, kind = bool(mission.remembered()), self.kind(noun)
        shown = [is_shown(house, view, noun, mission.spotter.config.sweep) for view in views]
        best = bool(shown) and shown[0]
        gone = claimed and not best
        return Answer(
            noun=noun,
            kind=kind,
            toured=noun in self.seen,
            remembered=claimed,
            right=best if kind != "removed" else not claimed,
            among=any(shown) if kind != "removed" else not claimed,
            stale=gone and any(is_shown(was, views[0], noun, mission.spotter.config.sweep) for was in self.houses[:-1]),
        )

    def kind(self, noun: str) -> str:
        for kind in ("moved", "added", "removed"):
            if noun in getattr(self.household, kind):
                return kind
        return "unchanged"


def is_shown(house: House, pose: np.ndarray, noun: str, sweep: float) -> bool:
    """Whether a robot at ``pose (3,)`` in the house frame, that also looks ``sweep`` to both sides, has it in view."""
    turns = [pose + [0.0, 0.0, side] for side in (0.0, sweep, -sweep)]
    return any(judge(World(house, config=WorldConfig(noise=False), start=turn), noun).in_view for turn in turns)


def straighten(robot: Robot) -> None:
    """What a host would make of the graph."""
    if not bent(robot.memory):
        return
    edges = robot.memory.edges()
    ends = np.column_stack([edges.i, edges.j])
    ids = np.unique(ends)
    parts = robot.memory.poses(ids), ends, edges.transforms, edges.information, edges.trusted
    robot.correct(ids, *optimise(ids, *parts))


def live(home: str, encoder: str, tours: int, changes: int, seed: int, limit: int) -> Iterator[Visit]:
    """All visits to one home. Raises HouseError when there is no such home."""
    with tempfile.TemporaryDirectory() as folder:
        yield from Life(home, encoder, tours, changes, seed, limit, Path(folder)).visits()


def show(visits: list[Visit]) -> str:
    """How many answers were right after each tour, over all homes.

    Of what stayed where it was, only things that nothing happened to until the end count: the same on every tour.
    """
    last = max(visit.tour for visit in visits)
    answers = {(v.tour, v.home, a.noun): a for v in visits for a in v.answers}
    lines = []
    for tour in range(1, last + 1):
        lines.append(f"after tour {tour}:")
        for kind in KINDS:
            until = last if kind == "unchanged" else tour
            mine = [
                answer
                for (when, home, noun), answer in answers.items()
                if when == tour and (end := answers.get((until, home, noun))) and end.kind == kind
            ]
            asked = [answer for answer in mine if answer.toured or kind == "removed"]
            if asked:
                right, among, stale = (sum(getattr(a, what) for a in asked) for what in ("right", "among", "stale"))
                lines.append(
                    f"  {kind:10} {right:3d} of {len(asked):3d} right, {among:3d} in the first three, {stale:3d} to an"
                    f" old place; {len(mine) - len(asked)} never in view since"
                )
    return "\n".join(lines)


def show_visit(visit: Visit) -> str:
    """One line."""
    before, after = visit.error
    return (
        f"{visit.home:12} tour {visit.tour}{'' if visit.complete else ' (out of time)'}: {visit.duration:5.0f} s, "
        f"{visit.answering} nodes answer, of {visit.nodes} (limit {visit.limit}); {visit.ram / 1e6:.2f} MB in RAM, "
        f"{visit.disk / 1e6:.1f} MB on disk; nodes {before:.3f} m off, straightened {after:.3f} m"
    )


def main(arguments: list[str] | None = None) -> None:
    """``vlpg eval life``."""
    parser = argparse.ArgumentParser(prog="vlpg eval life", description=__doc__.split(": ", 1)[1])
    parser.add_argument(
        "--homes", default="handmade", help="handmade (all of them), generated:0-39, or names, comma-separated"
    )
    parser.add_argument("--encoder", default=DEFAULT, metavar="MODEL", help="a model's name, or oracle: true labels")
    parser.add_argument("--tours", type=int, default=3, metavar="N", help="the home changes between them")
    parser.add_argument(
        "--changes", type=int, default=4, metavar="N", help="things moved, removed and added each time (default: 4)"
    )
    parser.add_argument("--seed", type=seed, default=0, help="of every source of noise, and of the changes")
    parser.add_argument(
        "--limit", type=int, default=VlpgConfig.limit, metavar="N", help="nodes that may answer (default: %(default)s)"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every answer there")
    options = parser.parse_args(arguments)
    if min(options.tours, options.limit) < 1 or options.changes < 0:
        parser.error("--tours and --limit must be at least 1, and --changes at least 0")
    if options.json:
        check_folder(parser, options.json)
    need_gtsam(parser)
    visits = []
    try:
        for home in homes_named(options.homes):
            for visit in live(home, options.encoder, options.tours, options.changes, options.seed, options.limit):
                visits.append(visit)
                print(show_visit(visit), flush=True)
    except (HouseError, ModelError) as error:
        parser.exit(2, f"vlpg eval life: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "\nvlpg eval life: stopped\n")
    print(f"\n{options.encoder} encoder, seed {options.seed}\n{show(visits)}")
    if options.json:
        options.json.write_text(json.dumps([asdict(visit) for visit in visits], indent=1))


if __name__ == "__main__":
    main()
