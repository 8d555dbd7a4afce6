"""Which candidate views become nodes of the graph, and which old nodes they replace."""

from dataclasses import dataclass
from math import radians
from typing import Literal, NamedTuple

import numpy as np

from edge.pose import wrap


@dataclass(frozen=True)
class GateConfig:
    """When a view is new, and when it contradicts an old one."""

    policy: Literal["novel", "dense"] = "novel"  # [V] offers both; dense keeps every candidate
    similarity: float = 0.90  # epsilon of [V] Eq. 1, cosine at and above which two views show the same
    distance: float = 0.50  # m; a similar view from further away is a node all the same (Eq. 1 corrected)
    angle: float = radians(30)  # rad; likewise for the heading; under half the 79 deg of the camera, so views overlap
    same_distance: float = 0.20  # m within which two poses are one place: the map's drift and a few grid cells
    same_angle: float = radians(8)  # rad; a tenth of the field of view, so that the regions still show the same things
    disagreement: float = 0.60  # cosine under which the same place shows something else now

    def __post_init__(self):
        if self.policy not in ("novel", "dense"):
            raise ValueError(f'gate policy is "{self.policy}"; it must be "novel" or "dense"')
        if self.same_distance > self.distance or self.same_angle > self.angle:
            raise ValueError("same_distance and same_angle must not exceed the gate's distance and angle")


class Verdict(NamedTuple):
    """What becomes of a candidate view."""

    admit: bool
    superseded: list[int]  # ids of the nodes that it replaces


def judge(pose, poses, answers, recent, cosines_with, config):
    """Decides on a candidate view.

    [V] Eq. 1 adds q* only if cos(q*, q) < epsilon for all q, which would refuse the same view seen from a second place.
    Corrected: the candidate is refused only for a similar node that is also *near*, within ``distance`` and ``angle``.

    Recent knowledge wins ([V]): a node at (nearly) the same pose that disagrees with the candidate is superseded, and
    the candidate is then admitted in any case, since it tells something new. Disagreement is that of the least similar
    region: a thing that appears in one third of the picture hardly moves the whole-picture cosine, and must not be
    missed.

    For the same reason only nodes of the same tour make a view known: that a cup is gone from a table hardly changes
    the picture, and a memory that refuses it would never learn. So that tours do not pile up, an old node nearby that
    shows the same in every region is superseded, as nothing is lost with it.

    Args:
        pose: (3,) where the candidate was seen.
        poses: (N, 3) of all nodes.
        answers: (N,) bool, False for superseded nodes.
        recent: (N,) bool, True for nodes of this tour.
        cosines_with: rows (M,) -> cosines (M, R) of the candidate's regions, the whole picture first, with each
            node's; NaN where a node lacks the region. Asked for near nodes only.
        config: GateConfig.
    """
    near, same_place = _near(pose, poses, answers, config)
    if not len(near):
        return Verdict(True, [])
    cosines, recent = cosines_with(near), recent[near]
    least = np.nanmin(cosines, axis=1)
    disagrees = same_place & (least < config.disagreement)
    known = recent & ~disagrees & (cosines[:, 0] >= config.similarity)
    if known.any() and not disagrees.any() and config.policy != "dense":
        return Verdict(False, [])
    renewed = ~recent & (least >= config.similarity)
    return Verdict(True, near[disagrees | renewed].tolist())


def is_known(pose, poses, answers, recent, cosines_with, config):
    """Whether ``judge`` refuses a candidate whatever its regions show: three passes of the image tower saved.

    That is so for a third of the candidates: only a node at the same pose can be contradicted by a region. Arguments
    as for ``judge``, with the cosines of the whole picture only.
    """
    near, same_place = _near(pose, poses, answers, config)
    if config.policy == "dense" or same_place.any() or not recent[near].any():
        return False
    return bool((recent[near] & (cosines_with(near)[:, 0] >= config.similarity)).any())


def _near(pose, poses, answers, config):
    """Rows of the nodes that have a say about a view from ``pose``, and which of them have (nearly) the same pose."""
    dense = config.policy == "dense"
    reach, turn = (config.same_distance, config.same_angle) if dense else (config.distance, config.angle)
    near = np.flatnonzero(answers & (np.abs(poses[:, 0] - pose[0]) <= reach))
    offsets = poses[near] - pose
    distances, angles = np.hypot(offsets[:, 0], offsets[:, 1]), np.abs(wrap(offsets[:, 2]))
    close = (distances <= reach) & (angles <= turn)
    same_place = (distances <= config.same_distance) & (angles <= config.same_angle)
    return near[close], same_place[close]
