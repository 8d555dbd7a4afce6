"""Loop closures: the embedding proposes that a place is an old one, the scans of both confirm or refuse it."""

from dataclasses import dataclass, field, replace

import numpy as np

from edge.localization.likelihood_field import LikelihoodField
from edge.localization.scan_matching import MatchConfig, match
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.motion import in_frame
from edge.memory.scan_bytes import unpack
from edge.memory.store import Vlpg
from edge.pose import between, compose, wrap

CONTRADICTS = 11.34  # squared Mahalanobis distance; chi-square with 3 degrees of freedom at 99 %


@dataclass(frozen=True)
class LoopConfig:
    """When two nodes may be the same place, and when they are."""

    recent: int = 20  # nodes; the newest are tied to this one by odometry already
    pause: int = 3  # nodes between attempts: neighbours would say the same
    alike: float = 0.80  # cosine of the whole pictures; the gate calls 0.90 the same view
    reach: float = 1.5  # m between the believed poses: more than a home's worth of drift
    turn: float = np.radians(40)  # rad; half a field of view, beyond which pictures share nothing
    neighbours: int = 3  # nodes to either side whose scans make the map of the old place
    score: float = 0.80  # share of the returns that must fit there
    # Wider than the localizer's search: odometry may have drifted since.
    match: MatchConfig = field(
        default_factory=lambda: replace(MatchConfig(), search_distance=0.8, search_angle=np.radians(15))
    )


class LoopCloser:
    """Adds "loop" edges to a memory as its nodes arrive."""

    def __init__(self, memory: Vlpg, config: LoopConfig | None = None):
        self.config = config or LoopConfig()
        self._memory = memory
        self._last = -self.config.pause  # node of the last attempt

    def consider(self, node: int) -> int | None:
        """Try to close a loop at a new ``node``, which keeps its scan; the old node it was tied to, or None."""
        memory, config = self._memory, self.config
        data = memory.scan(node)
        if data is None or node - self._last < config.pause:
            return None
        old = self._proposed(node)
        if old is None:
            return None
        self._last = node
        scan, offset = unpack(data)
        there = memory.poses([old])[0]
        field_ = LikelihoodField.around(self._place(old), there, scan.range_max + 0.5)
        found = match(field_, scan, compose(memory.poses([node])[0], offset), config.match)
        if found.score < config.score:
            return None
        pose = compose(found.pose, between(offset, np.zeros(3)))
        memory.link(old, node, between(there, pose), np.linalg.inv(in_frame(found.covariance, there[2])), kind="loop")
        return old

    def _proposed(self, node: int) -> int | None:
        """The old node, near enough to be the same place, whose picture is most like that of ``node``."""
        memory, config = self._memory, self.config
        ids = memory.ids
        ids = ids[ids < node - config.recent]
        away = memory.poses(ids) - memory.poses([node])
        near = (np.hypot(away[:, 0], away[:, 1]) <= config.reach) & (np.abs(wrap(away[:, 2])) <= config.turn)
        ids = ids[near]
        if not len(ids):
            return None
        cosines = memory.cosines(ids, memory.view(node)[0][:1])[:, 0]
        best = int(cosines.argmax())
        return int(ids[best]) if cosines[best] >= config.alike else None

    def _place(self, old: int) -> OccupancyGrid:
        """A small map of where ``old`` is, from its own scan and those of its neighbours in time."""
        memory, grid = self._memory, OccupancyGrid()
        held = memory.held
        at = int(np.searchsorted(held, old))
        for node in held[max(0, at - self.config.neighbours) : at + self.config.neighbours + 1].tolist():
            if (data := memory.scan(node)) is not None:
                scan, offset = unpack(data)
                grid.integrate_scan(compose(memory.poses([node])[0], offset), scan)
        return grid


def bent(memory: Vlpg) -> bool:
    """Whether most loop closures contradict the nodes' poses, so that straightening the graph is worth it.

    Where scans are matched with one map, nodes lie within centimetres and most closures say so; straightening could
    then only spread the error of a false one.
    """
    edges = memory.edges()
    loops = [number for number, kind in enumerate(edges.kinds) if kind == "loop"]
    if not loops:
        return False
    first, second = memory.poses(edges.i[loops]), memory.poses(edges.j[loops])
    errors = between(first, second) - edges.transforms[loops]
    errors[:, 2] = wrap(errors[:, 2])
    return bool(np.median(np.einsum("li,lij,lj->l", errors, edges.information[loops], errors)) > CONTRADICTS)
