"""One object sought in one unknown home, and what came of it ([U] Sec. V)."""

from dataclasses import dataclass
from zlib import crc32

import cv2
import numpy as np

from edge.memory.store import Vlpg
from edge.perception.prompts import Target
from edge.pose import between, transform
from edge.robot import Robot, RobotConfig
from firmware_sim.home import load_home
from firmware_sim.world import World, WorldConfig
from tools.eval.objectnav.actions import Action, Actor
from tools.eval.objectnav.agent import Agent
from tools.eval.objectnav.goal_region import CLEARANCE, GoalRegion
from tools.eval.objectnav.planners import Planner
from tools.eval.oracle import OracleEncoder
from tools.eval.tour import names_in_view

# It does not remember what it sees: the protocol asks one question a home, and a third of the time would go there.
FORGETFUL = RobotConfig(candidate_distance=np.inf, candidate_angle=np.inf)
SCANS = 0.3  # s between lidar turns: three a step


@dataclass(frozen=True, slots=True)
class Episode:
    """A question, how it ended, and the truth."""

    home: str
    planner: str
    noun: str
    ending: str  # "found", "guessed", "explored" or "out of actions"
    success: bool  # it stops of its own accord, and stands within the clearance of an instance, in line of sight
    spl: float  # success weighted by path length (Anderson et al. 2018)
    cause: str  # why it failed; "" when it did not
    claimed: str  # the name of what stands where it says that the thing is; "" when it says nothing
    actions: int
    length: float  # m driven
    shortest: float  # m, from the start to the nearest place where stopping counts
    distance: float  # m to the nearest instance in line of sight at the end; infinite without
    bumps: int
    seen: bool  # some picture showed the object
    confidence: float  # of the best close look; 0 without


class Run:
    """An episode as it goes on, action by action."""

    def __init__(self, home: str, noun: str, planner: Planner, encoder, seed: int):
        """``encoder``: one that is loaded, or None for the oracle."""
        # By home, or the same wheel would be the worn one in all of them; and the random planner choose alike.
        house = load_home(home)
        noise, draw = (crc32(f"{seed} {what}".encode()) for what in (house.name, f"{house.name} {noun}"))
        self.world = World(house, noise, WorldConfig(scan_period=SCANS))
        encoder = encoder or OracleEncoder(self.world)
        memory = Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim)
        self.robot = Robot(encoder, memory, self.world.config.camera_model, FORGETFUL)
        target = Target.of(noun, encoder)
        self.agent = Agent(self.robot, planner.exploration(self.robot, target, draw))
        self.actor = Actor(self.world)
        self.seen = False
        self.bumps: list[int] = []  # numbers of the actions that ended at an obstacle
        self.noun = noun
        self._observation = self.world.step(None)

    def step(self) -> None:
        """One action: look, choose, carry it out."""
        action = self.choose()
        if not self.done:
            self.carry_out(action)

    def choose(self) -> Action:
        """What the robot does next, given what it sees."""
        self.seen |= self.noun in names_in_view(self.world)
        return self.agent.act(self._observation)

    def carry_out(self, action: Action) -> None:
        """Let it happen."""
        touched = False

        def heed(observation):
            nonlocal touched
            touched |= observation.bumper
            self.robot.perceive(observation)

        self._observation = self.actor.act(action, heed)
        if touched or self._observation.bumper:
            self.bumps.append(self.agent.actions)

    def in_map(self, places) -> np.ndarray:
        """True ``places (N, 2)`` [m] of the house, in the frame that the robot's map began with."""
        return transform(between(self.world.house.start, np.zeros(3)), places)

    def in_house(self, place) -> np.ndarray:
        """A ``place (2,)`` [m] of the map, in the house."""
        return transform(self.world.house.start, np.asarray(place)[None])[0]

    @property
    def done(self) -> bool:
        return bool(self.agent.ending)


def explore(home: str, name: str, noun: str, planner: Planner, encoder, seed: int) -> Episode:
    """Seek ``noun`` with the ``planner`` called ``name``; ``encoder`` None is the oracle."""
    run = Run(home, noun, planner, encoder, seed)
    start = run.world.truth[:2]
    length, here = 0.0, start
    while not run.done:
        run.step()
        length += float(np.hypot(*(run.world.truth[:2] - here)))
        here = run.world.truth[:2]
    region = GoalRegion(run.world.house, noun)
    distance, shortest = region.distance(here), region.shortest_path(start)
    best = run.agent.exploration.best
    success = run.agent.ending in ("found", "guessed") and distance <= CLEARANCE
    return Episode(
        home=run.world.house.name,
        planner=name,
        noun=noun,
        ending=run.agent.ending,
        success=success,
        spl=shortest / max(shortest, length) if success else 0.0,
        cause="" if success else _cause(run, region),
        claimed=_claimed(run),
        actions=run.agent.actions,
        length=length,
        shortest=shortest,
        distance=distance,
        bumps=len(run.bumps),
        seen=run.seen,
        confidence=best.confidence if best else 0.0,
    )


def _claimed(run: Run) -> str:
    """What is nearest to the place that it drove to in the end."""
    aim = run.agent.aim
    if aim is None:
        return ""
    place = run.in_house(aim.nearest(run.robot.pose)).tolist()

    def inside(thing):  # m, negative outside of it
        return cv2.pointPolygonTest(thing.footprint.astype(np.float32), place, True)

    return max(run.world.house.objects.values(), key=inside).model.name


LAST = 50  # actions; a robot that bumped in a third of its last ones was caught
AIMED = 0.5  # m from the object's outline; a robot that aimed there meant it


def _cause(run: Run, region: GoalRegion) -> str:
    ending, actions, aim = run.agent.ending, run.agent.actions, run.agent.aim
    if aim is not None and region.shows(run.in_house(aim.nearest(run.robot.pose)), AIMED):
        return "stopped short"
    if aim is not None:
        return "false positive" if ending == "found" else "wrong guess"
    if sum(bump > actions - LAST for bump in run.bumps) >= LAST / 3:
        return "collision trap"
    if run.seen:
        return "seen but missed"
    return "timeout" if ending == "out of actions" else "never seen"
