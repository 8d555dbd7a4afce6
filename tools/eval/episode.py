"""One question in one home, and what came of it."""

from dataclasses import dataclass
from math import nan

import numpy as np

from edge.perception.prompts import Target
from edge.pose import between, compose
from firmware_sim.world import World
from tools.eval.disturbance import Impossible, disturb
from tools.eval.judge import instances_of, judge
from tools.eval.methods import mission_for
from tools.eval.tour import Tour, names_in_view, run


@dataclass(frozen=True, slots=True)
class Episode:
    """A question, the answer, and the truth."""

    home: str
    method: str
    noun: str
    disturbance: str  # what happened to the home or the robot after the tour; "" when nothing did
    truth: str  # the part of the robot that knew the truth; "" when none did
    toured: bool  # the mapping tour had the object in view
    status: str  # what the robot says
    success: bool  # what is true: it says found, and the object is in view; or it says that what is gone is not here
    cause: str  # why it failed; "" when it did not
    in_view: bool
    angular_error: float  # rad; NaN when the home has no such object
    pixel_error: float  # px, columns from the picture's middle to the object's; NaN when it is not in the picture
    score: float  # of the sighting that the answer rests on; NaN without one
    remembered: float  # the memory's best score there; NaN without a sighting
    confidence: float  # that the robot states
    duration: float  # s, simulated
    distance: float  # m
    contacts: int  # collisions
    pose_error: float  # m, of the robot's own pose at the end


def ask(tour: Tour, method: str, noun: str, disturbance: str, search: bool, seed: int) -> Episode | None:
    """Let ``method`` look for ``noun``; judged where the robot comes to rest. None if it cannot be so disturbed."""
    if disturbance:
        try:
            disturb(disturbance, tour, noun, seed)
        except Impossible:
            return None
    world, contacts, met = tour.world, tour.world.contacts, set()
    mission = mission_for(method, tour, Target.of(noun, tour.robot.encoder), search, seed)
    if mission.robot is tour.robot:
        origin = world.house.start
    else:  # a new robot's map begins where odometry did
        origin = compose(world.truth, between(world.odometry.pose, np.zeros(3)))
    run(world, mission, lambda: met.update(names_in_view(world)))
    outcome, verdict = mission.outcome, judge(world, noun)
    if instances_of(world.house, noun):
        success = outcome.status == "found" and verdict.in_view
    else:
        success = outcome.status in ("not found", "not in memory")
    claim = outcome.claim
    return Episode(
        home=world.house.name,
        method=method,
        noun=noun,
        disturbance=disturbance,
        truth=tour.truth,
        toured=noun in tour.in_view,
        status=outcome.status,
        success=success,
        cause="" if success else _cause(outcome.status, noun in tour.in_view, noun in met),
        in_view=verdict.in_view,
        angular_error=verdict.angular_error,
        pixel_error=_pixel_error(world, verdict.object_id),
        score=nan if claim is None else claim.sighting.detection.score,
        remembered=nan if claim is None else claim.remembered,
        confidence=outcome.confidence,
        duration=outcome.duration,
        distance=outcome.distance,
        contacts=world.contacts - contacts,
        pose_error=float(np.hypot(*between(mission.robot.pose, between(origin, world.truth))[:2])),
    )


def _cause(status: str, toured: bool, met: bool) -> str:
    if status == "found":
        return "claims another thing"
    if status == "not in memory":
        return "not recognized in memory" if toured else "never seen on the tour"
    if status == "timeout":
        return "out of time"
    if status == "lost":
        return "did not find its own place"
    return "in view but not recognized" if met else "looked elsewhere"


def _pixel_error(world: World, object_id: str) -> float:
    """Columns between the picture's middle and that of the object's box in it."""
    if object_id not in world.object_ids:
        return nan
    columns = np.flatnonzero((world.picture.instances == world.object_ids.index(object_id)).any(0))
    if not len(columns):
        return nan
    return float(abs((columns[0] + columns[-1]) / 2 - world.config.camera_model.centre[0]))
