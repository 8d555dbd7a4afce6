"""What is true about a claim to have found something ([V] Sec. IV-A)."""

from dataclasses import dataclass
from math import exp, nan, pi

import numpy as np

from edge.pose import wrap
from firmware_sim.house import House, HouseObject
from firmware_sim.world import World

# Of an object's whole silhouette. Near a bed most of it is outside the picture, yet nobody would say it is not in view.
VISIBLE_SHARE = 0.3


@dataclass(frozen=True, slots=True)
class Verdict:
    """Of the instances of a noun, the one that the robot looks at best."""

    in_view: bool  # inside the field of view, and not hidden
    object_id: str  # "" when the home has none
    angular_error: float  # rad between the heading and the line of sight to the true centre; NaN without an instance


def instances_of(house: House, noun: str) -> list[HouseObject]:
    """The objects whose model is named ``noun``, whatever its case."""
    return [thing for thing in house.objects.values() if thing.model.name.lower() == noun.lower()]


def judge(world: World, noun: str) -> Verdict:
    """Look through the simulator's eyes for any object that is called ``noun``."""
    best = Verdict(False, "", nan)
    for thing in instances_of(world.house, noun):
        x, y, heading = world.truth
        error = abs(float(wrap(np.arctan2(thing.y - y, thing.x - x) - heading)))
        inside = error <= world.config.camera_model.hfov / 2
        in_view = bool(inside and world.visible_fraction(thing.id) >= VISIBLE_SHARE)
        if not best.object_id or (not in_view, error) < (not best.in_view, best.angular_error):
            best = Verdict(in_view, thing.id, error)
    return best


def sae_terms(successes, angular_errors) -> list[float]:
    """``S_i exp(-(error_i / 90 deg)^2)`` of each episode; errors in rad, NaN where there is nothing to look at."""
    errors = np.nan_to_num(np.asarray(angular_errors, float))
    return [exp(-((error / (pi / 2)) ** 2)) if success else 0.0 for success, error in zip(successes, errors)]


def sae(successes, angular_errors) -> float:
    """Success weighted by angular error, the mean of ``sae_terms``; NaN without an episode."""
    terms = sae_terms(successes, angular_errors)
    return sum(terms) / len(terms) if terms else nan
