"""Asking the memory: what it has seen, less what later tours have looked for in the same places in vain."""

from dataclasses import dataclass
from math import tan

import numpy as np

from edge.camera import CameraModel
from edge.memory.nodes import COLUMNS
from edge.memory.store import Vlpg
from edge.memory.vectors import Hits


@dataclass(frozen=True)
class RecallConfig:
    """When views outvote a hit of an earlier tour."""

    cell: float = 0.5  # m, in which places are told apart: a piece of furniture; half of it takes twice as long
    far: float = 7.0  # m, from which a thing may have been seen: a large one across a room and a half
    near: float = 3.0  # m, from which a view that does not show a thing speaks against it; as in `CoverageConfig`
    open: float = 0.9  # of the depth camera's range; returns from beyond are the floor of an open room and end no view
    slack: float = 0.4  # m beyond what ended a view: things have a depth, and stand on what ended it
    alike: float = 0.5  # of the hit's score; a view that scores less does not show the thing
    likely: float = 0.7  # of the most votes that a place of the hit has; such places may be where the thing was
    votes: int = 3  # views of a later tour that decide about a place; fewer may all be mistaken
    refuted: float = 0.5  # share of the likely places; from there on the hit falls


def recall(memory: Vlpg, direction, k: int, camera: CameraModel, config: RecallConfig = RecallConfig()) -> Hits:
    """The hits of [V] Eq. 2 (see ``Vlpg.search``) that still stand, at most ``k``, best first.

    Recent knowledge wins ([V] Sec. III-A), and not only where two views are from the same pose. A hit claims that the
    thing is somewhere in the view of its region. Where, the views of its own tour tell: those that show a place and
    score alike are for it, those that looked at it from near and do not are against it. The hit falls when, of the
    likely places, half were looked at again and most views of the last tour that did so are against them. Nothing is
    forgotten by that: for another thing in the same view there is another vote.
    """
    latest, ballot = memory.tours(memory.ids).max(initial=0), None
    wanted = k
    while True:  # what was well known fills k hits, and may all fall
        hits = memory.search(direction, wanted)
        stands = np.ones(len(hits.ids), bool)
        doubtful = np.flatnonzero((memory.tours(hits.ids) < latest) & (hits.scores > 0))
        if len(doubtful):
            ballot = ballot or Ballot(memory, direction, camera, config)
            stands[doubtful] = ballot.upheld(*(part[doubtful] for part in hits))
        if stands.sum() >= k or len(hits.ids) < wanted:
            return Hits(*(part[stands][:k] for part in hits))
        wanted *= 2


class Ballot:
    """What all views say about where one thing is."""

    def __init__(self, memory: Vlpg, direction, camera: CameraModel, config: RecallConfig):
        self.config, self.camera = config, camera
        self.ids = memory.ids
        self.tours, self.reach, poses = memory.tours(self.ids), memory.reach(self.ids), memory.poses(self.ids)
        self.rounds, self.starts = np.unique(self.tours, return_index=True)  # the tours; ids and tours ascend together
        self.ahead = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
        self.aside = self.ahead[:, ::-1] * [-1, 1]
        self.eyes = poses[:, :2] + camera.ahead * self.ahead + camera.left * self.aside
        self.scores, bearings = memory.scores(self.ids, direction)
        # If the thing stands elsewhere in the picture, the whole of it scores too; its windows tell, where there are.
        self.scores[~np.isnan(self.scores[:, 1:]).all(axis=1), 0] = np.nan
        self.slopes = np.tan(bearings)
        self.edge = tan(camera.hfov / 2)  # slope of the picture's edge; a window is half as wide

    def upheld(self, nodes, scores, bearings) -> np.ndarray:
        """Which hits, with ``(H,)`` nodes, scores and bearings [rad], stand, bool."""
        owners = np.searchsorted(self.ids, nodes)
        claims = [self.claimed(owner, slope) for owner, slope in zip(owners, np.tan(bearings), strict=True)]
        places, index = np.unique(np.concatenate(claims), axis=0, return_inverse=True)
        said, near = self.asked((places + 0.5) * self.config.cell)
        parts = np.split(index.ravel(), np.cumsum([len(claim) for claim in claims])[:-1])
        return np.array(
            [self.stands(owner, score, said[part], near[part]) for owner, score, part in zip(owners, scores, parts)]
        )

    def stands(self, owner: int, score: float, said: np.ndarray, near: np.ndarray) -> bool:
        """Whether a hit does, given what the views (N) said about its places (P), and which looked from near."""
        config, alike = self.config, said >= self.config.alike * score
        favour, against, looked = (self.by_tour(votes) for votes in (alike, near & ~alike, near))
        own = int(np.searchsorted(self.rounds, self.tours[owner]))
        # Where nobody looked from near on any tour, nobody could have spoken against it.
        margin = np.where(looked.any(axis=1), favour[:, own] - against[:, own], -len(self.ids))
        likely = margin >= min(config.likely * margin.max(), margin.max())
        later, against = looked[likely, own + 1 :], against[likely, own + 1 :]
        decided = later >= config.votes
        last = np.arange(len(later)), decided.shape[1] - 1 - decided[:, ::-1].argmax(axis=1)
        refuted = decided[last] & (2 * against[last] > later[last])
        return refuted.mean() < config.refuted

    def by_tour(self, votes: np.ndarray) -> np.ndarray:
        """How many of ``votes (P, N)`` are from each tour, ``(P, T)``."""
        return np.add.reduceat(votes, self.starts, axis=1, dtype=np.int32)

    def claimed(self, owner: int, slope: float) -> np.ndarray:
        """Cells ``(P, 2)`` int, x and y, of the region around ``slope`` in the view of row ``owner``."""
        slopes = np.clip(slope + np.linspace(-0.5, 0.5, 9) * self.edge, -self.edge, self.edge)
        slopes, depths = np.meshgrid(slopes, np.arange(self.camera.min_depth, self.config.far, self.config.cell))
        inside = depths <= np.maximum(self.ends(np.full(slopes.shape, owner), slopes), self.camera.min_depth)
        slopes, depths = slopes[inside, None], depths[inside, None]
        points = self.eyes[owner] + depths * (self.ahead[owner] + slopes * self.aside[owner])
        return np.unique(np.floor(points / self.config.cell).astype(np.int64), axis=0)

    def asked(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The scores ``(P, N)`` that views show at places (P, 2), -inf where they do not, and who looked from near."""
        depths, across = (
            places.astype(np.float32) @ axis.T.astype(np.float32) - (self.eyes * axis).sum(axis=1).astype(np.float32)
            for axis in (self.ahead, self.aside)
        )
        place, view = np.nonzero((np.abs(across) <= self.edge * depths) & (depths <= self.config.far))
        depth, across = depths[place, view], across[place, view]
        slope = across / np.maximum(depth, 1e-6)
        shown = depth <= self.ends(view, slope)
        place, view, depth, across, slope = (part[shown] for part in (place, view, depth, across, slope))
        covers = np.abs(slope[:, None] - self.slopes[view]) <= self.edge / 2
        scores = np.fmax.reduce(np.where(covers, self.scores[view], np.nan), axis=1)
        said, near = np.full(depths.shape, -np.inf, np.float32), np.zeros(depths.shape, bool)
        said[place, view] = np.nan_to_num(scores, nan=-np.inf)
        near[place, view] = ~np.isnan(scores) & (np.hypot(depth, across) <= self.config.near) & self.known[view]
        return said, near

    @property
    def known(self) -> np.ndarray:
        """``(N,)`` bool, whether it is known how far the views went."""
        return self.reach.any(axis=1)

    def ends(self, views: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Depth [m] at which ``views`` ended at ``slopes``; infinity where the depth camera saw no end."""
        share = np.clip(0.5 - slopes / self.edge / 2, 0, 1)  # of the picture's width
        depth = self.reach[views, np.rint(share * (COLUMNS - 1)).astype(np.intp)]
        ended = (depth > 0) & (depth < self.config.open * self.camera.max_depth)
        return np.where(ended, depth + self.config.slack, np.inf)
