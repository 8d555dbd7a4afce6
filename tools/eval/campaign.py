"""The questions of ``vlpg eval find``: many homes, each mapped once and asked many questions."""

import json
import random
from dataclasses import dataclass, fields
from math import nan
from pathlib import Path

from edge.bench import vlmaps
from edge.missions.map_home import HomeMapped
from models.manifest import DEFAULT
from tools.eval.child import in_child
from tools.eval.episode import Episode, ask
from tools.eval.tour import Tour, map_home, nouns


@dataclass(frozen=True, slots=True)
class HomeResult:
    """All episodes in one home."""

    home: str
    mapped: HomeMapped
    memory: int  # bytes of the VLPG in RAM: vectors, poses, spare room
    dense: int  # bytes of a VLMaps grid of the same home
    episodes: list[Episode]


@dataclass(frozen=True, slots=True)
class Plan:
    """What is asked in each home."""

    methods: tuple[str, ...] = ("vlpg-nav",)
    encoder: str = DEFAULT  # a model's name, or "oracle"
    objects: int | None = None  # so many of those that the tour had in view, drawn by lot; None: all of the home
    disturbances: tuple[str, ...] = ()  # each question is asked as it is, and once with each of these
    truths: tuple[str, ...] = ()  # VLPG-Nav is asked once more with each of these parts replaced by the truth
    search: bool = False  # VLPG-Nav looks even for what does not seem to be in its memory
    seed: int = 0  # of every source of noise

    def run(self, home: str) -> HomeResult:
        """Map one home; each question of each method then starts from the end of that tour."""
        tour = map_home(home, self.encoder, self.seed)
        asked = chosen(tour, self)
        episodes = [
            in_child(ask, tour, method, noun, disturbance, self.search, self.seed)
            for noun in asked
            for disturbance in ("", *self.disturbances)
            for method in self.methods
        ]
        for truth in self.truths:
            told = map_home(home, self.encoder, self.seed, truth)
            episodes += [in_child(ask, told, "vlpg-nav", noun, "", self.search, self.seed) for noun in asked]
        return HomeResult(
            home=tour.world.house.name,
            mapped=tour.mapped,
            memory=tour.robot.memory.nbytes,
            dense=vlmaps.nbytes(tour.robot.grid),
            episodes=[episode for episode in episodes if episode is not None],
        )

    def read(self, raw: dict) -> HomeResult:
        return _result(raw)

    def columns(self) -> list[str]:
        return [field.name for field in fields(Episode)]


def chosen(tour: Tour, plan: Plan) -> list[str]:
    """The names to ask for; the same for every encoder and method as long as the tour saw the same."""
    everything = nouns(tour.world.house)
    if plan.objects is None:
        return everything
    seen = [noun for noun in everything if noun in tour.in_view]
    return sorted(random.Random(tour.world.house.name).sample(seen, min(plan.objects, len(seen))))


def read(file: Path) -> list[HomeResult]:
    """What ``spread.write`` wrote of these. Raises OSError, or ValueError when the file holds something else."""
    try:
        homes = json.loads(file.read_text())["homes"]
        for raw in homes:
            raw["episodes"] = [{key: nan if v is None else v for key, v in e.items()} for e in raw["episodes"]]
        return [_result(raw) for raw in homes]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{file} does not hold the episodes of an evaluation ({error})") from None


def _result(raw: dict) -> HomeResult:
    raw["mapped"], raw["episodes"] = HomeMapped(**raw["mapped"]), [Episode(**e) for e in raw["episodes"]]
    return HomeResult(**raw)
