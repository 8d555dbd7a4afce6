"""What ``vlpg eval objectnav`` asks in each home: the same objects of every planner."""

import random
from dataclasses import dataclass, fields

import numpy as np

from edge.localization.localizer import LocalizerConfig
from edge.mapping.coverage import CoverageConfig
from edge.mapping.object_goal import ObjectGoalConfig
from edge.mapping.occupancy import OccupancyConfig
from edge.mapping.relevance import RelevanceConfig
from edge.missions.exploration import ExplorationConfig
from edge.perception.detection import DetectorConfig
from edge.perception.encoder import Encoder
from edge.planning.standpoint import StandpointConfig
from edge.robot import RobotConfig
from firmware_sim.home import load_home
from firmware_sim.house import House
from models.manifest import DEFAULT
from tools.eval.objectnav.actions import ActorConfig
from tools.eval.objectnav.agent import AgentConfig
from tools.eval.objectnav.candidates import CandidateConfig
from tools.eval.objectnav.episode import Episode, explore
from tools.eval.objectnav.goal_region import CLEARANCE, GoalRegion
from tools.eval.objectnav.planners import Planner
from tools.eval.tour import nouns

# What of the robot and the protocol may change from one release to the next, as it is in this one.
SETTINGS = repr(
    (AgentConfig(), ActorConfig(), CoverageConfig(), DetectorConfig(), ExplorationConfig(), LocalizerConfig())
    + (ObjectGoalConfig(), OccupancyConfig(), RelevanceConfig(), RobotConfig(), StandpointConfig(), CandidateConfig())
)


@dataclass(frozen=True, slots=True)
class HomeResult:
    """All episodes in one home."""

    home: str
    episodes: list[Episode]


@dataclass(frozen=True, slots=True)
class Plan:
    """Which planners seek how many things in each home."""

    planners: tuple[tuple[str, Planner], ...]  # with their names
    encoder: str = DEFAULT  # a model's name, or "oracle"
    objects: int | None = 1  # a home, drawn by lot; None: all
    seed: int = 0  # of every source of noise
    settings: str = SETTINGS  # kept results are of these, and count for no others

    def run(self, home: str) -> HomeResult:
        """Each planner seeks each object from the home's dock, in a world of its own."""
        house = load_home(home)
        encoder = None if self.encoder == "oracle" else Encoder.load(self.encoder)
        asked = chosen(house, self.objects)
        episodes = [
            explore(home, name, noun, planner, encoder, self.seed) for noun in asked for name, planner in self.planners
        ]
        return HomeResult(house.name, episodes)

    def read(self, raw: dict) -> HomeResult:
        return HomeResult(raw["home"], [Episode(**episode) for episode in raw["episodes"]])

    def columns(self) -> list[str]:
        return [field.name for field in fields(Episode)]


def chosen(house: House, objects: int | None) -> list[str]:
    """Names of things that can be reached, and are not within the clearance from the start: so many, or all."""
    start = house.start[:2]
    far = [noun for noun in nouns(house) if CLEARANCE / 2 < GoalRegion(house, noun).shortest_path(start) < np.inf]
    return far if objects is None else sorted(random.Random(house.name).sample(far, min(objects, len(far))))
