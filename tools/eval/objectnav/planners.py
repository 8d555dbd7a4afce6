"""The planners of [U] Table II: one code path, another acquisition function, and for VLFM its own map and prompt."""

from dataclasses import dataclass, replace

import numpy as np

from edge.mapping.relevance import RelevanceConfig, RelevanceMap
from edge.missions.exploration import ExplorationConfig
from edge.perception.prompts import ENSEMBLE, Target
from edge.planning.acquisition import BETA, expected_improvement, upper_confidence_bound
from edge.planning.frontier_choice import Acquisition, ChoiceConfig
from edge.robot import Robot
from tools.eval.objectnav.candidates import CandidateExploration
from tools.eval.objectnav.value_map import ValueMap

VLFM_PROMPT = 0  # index in ENSEMBLE of the one that VLFM uses


@dataclass(frozen=True, slots=True)
class Planner:
    """How frontiers are chosen. Two that are equal choose alike."""

    acquisition: str  # one of ACQUISITIONS
    prompts: tuple[int, ...] = tuple(range(len(ENSEMBLE)))  # indices in ENSEMBLE
    values: bool = False  # VLFM's map in place of the Gaussian one
    beta: float = BETA  # of GP-UCB
    off_axis: float = RelevanceConfig.off_axis  # kappa, of the Gaussian map
    tie: float = ChoiceConfig.tie  # of the best score, by which a nearer frontier's may be less
    calibrated: bool = True  # False: raw cosines, as printed

    def exploration(self, robot: Robot, target: Target, seed: int) -> CandidateExploration:
        """An exploration that follows it; ``seed`` is the random planner's."""
        texts = [ENSEMBLE[index].format(target.name) for index in self.prompts]
        relevance = ValueMap() if self.values else RelevanceMap(RelevanceConfig(off_axis=self.off_axis))
        acquisition = ACQUISITIONS[self.acquisition](self, seed)
        # A draw means nothing the next time: the random planner keeps to what it has drawn.
        choice = ChoiceConfig(tie=0.0, margin=np.inf) if self.acquisition == "random" else ChoiceConfig(tie=self.tie)
        kind = CandidateExploration if self.calibrated else _Raw
        vectors = robot.encoder.encode_text(texts)
        return kind(robot, target, vectors, acquisition, relevance, ExplorationConfig(choice=choice))


class _Raw(CandidateExploration):
    def promise(self, view):
        return self.prompts @ view.vectors[0]


def _improvement(planner: Planner, seed: int) -> Acquisition:
    return lambda means, variances, distances: expected_improvement(means, variances)


def _bound(planner: Planner, seed: int) -> Acquisition:
    return lambda means, variances, distances: upper_confidence_bound(means, variances, planner.beta)


def _mean(planner: Planner, seed: int) -> Acquisition:
    return lambda means, variances, distances: means


def _closest(planner: Planner, seed: int) -> Acquisition:
    return lambda means, variances, distances: -distances


def _random(planner: Planner, seed: int) -> Acquisition:
    rng = np.random.default_rng(seed)
    return lambda means, variances, distances: rng.uniform(size=len(distances))


ACQUISITIONS = {
    "improvement": _improvement,
    "bound": _bound,
    "mean": _mean,
    "closest": _closest,
    "random": _random,
}

PLANNERS = {
    "I-FBE1": Planner("improvement"),
    "I-FBE2": Planner("bound"),
    "mean": Planner("mean"),  # not in [U]: what the map is worth without its variance
    "VLFM": Planner("mean", (VLFM_PROMPT,), values=True),
    "random": Planner("random"),
    "closest": Planner("closest"),
}


def single_prompts() -> dict[str, Planner]:
    """[U] Table I: VLFM with each prompt of the ensemble alone."""
    return {f"VLFM, prompt {index + 1}": replace(PLANNERS["VLFM"], prompts=(index,)) for index in range(len(ENSEMBLE))}


def sub_ensembles(seed: int, size: int = 4) -> dict[str, Planner]:
    """I-FBE2 with as many different ensembles of ``size`` prompts, drawn by lot, as there are prompts."""
    rng, drawn = np.random.default_rng(seed), set()
    while len(drawn) < len(ENSEMBLE):
        drawn.add(tuple(sorted(int(index) for index in rng.choice(len(ENSEMBLE), size, replace=False))))
    names = ("".join(str(index + 1) for index in prompts) for prompts in sorted(drawn))
    return {f"I-FBE2, prompts {name}": replace(PLANNERS["I-FBE2"], prompts=p) for name, p in zip(names, sorted(drawn))}
