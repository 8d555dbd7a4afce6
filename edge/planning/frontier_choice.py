"""Which frontier to explore next, and for how long to keep to it ([U] Sec. IV)."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from edge.mapping.frontiers import Frontier

# Frontiers' relevance means and variances and their distances [m], each (N,), to scores (N,): the highest is chosen.
Acquisition = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class ChoiceConfig:
    """What makes a choice last, and what makes it end."""

    disc: float = 0.5  # m around a waypoint whose relevance is the frontier's, [U] Sec. IV
    same: float = 1.0  # m; a frontier whose waypoint lies no further from the last one's is the same, grown or shrunk
    tie: float = 0.05  # of the best score; of frontiers that are worse by no more, the nearest is taken
    margin: float = 0.1  # of the best score, by which that must beat the one of the frontier kept to
    progress: float = 0.2  # m from where the robot has been on the way there, or it is no progress
    patience: int = 20  # choices of the same frontier without progress, after which it is dropped


TOWARD = ChoiceConfig()  # for the way to a place, whatever the acquisition function


@dataclass
class _Trial:
    """What came of making for a frontier so far."""

    waypoint: np.ndarray  # (2,) m, where it was, and
    latest: int = 0  # which choice, when it was chosen last
    been: list[np.ndarray] = field(default_factory=list)  # (2,) m
    stalled: int = 0  # choices since the robot last came to a new place


class FrontierChoice:
    """Keeps to a frontier until it is gone, clearly beaten, or cannot be approached.

    With close means expected improvement ranks by the deviation alone, which shrinks with each view, so that without
    the margin the robot would dither between two frontiers.
    """

    def __init__(self, acquisition: Acquisition, config: ChoiceConfig | None = None):
        self.config = config or ChoiceConfig()
        self.offered: list[Frontier] = []  # the ones of the last choice, and
        self.scores = np.zeros(0)  # (N,), theirs
        self._acquisition = acquisition
        self._kept: np.ndarray | None = None  # (2,) m, waypoint of the last choice
        self._trials: list[_Trial] = []
        self._choices = 0  # made so far
        self._dropped: list[np.ndarray] = []  # (2,) m, for good
        self._later: list[np.ndarray] = []  # (2,) m, when no other is left
        self._tried_again: list[np.ndarray] = []  # (2,) m

    def choose(self, frontiers: list[Frontier], relevance, position) -> Frontier | None:
        """The frontier to drive to from ``position (2,)`` or pose; None when there is none left.

        ``relevance`` has ``around(place, radius)``: median mean and variance near a place.
        """

        def scores(waypoints, away):
            means, variances = np.array([relevance.around(place, self.config.disc) for place in waypoints]).T
            return self._acquisition(means, variances, away)

        return self._best(frontiers, scores, np.asarray(position, float)[:2], self.config)

    def choose_toward(self, frontiers: list[Frontier], place, position) -> Frontier | None:
        """The frontier nearest to ``place (2,)`` [m], to which no way is known yet; None when there is none left."""

        def scores(waypoints, away):
            return -np.hypot(*(waypoints - place).T)

        return self._best(frontiers, scores, np.asarray(position, float)[:2], TOWARD)

    def _best(self, frontiers, scores_of, position, config: ChoiceConfig) -> Frontier | None:
        left = [frontier for frontier in frontiers if not self._is_in(self._dropped + self._later, frontier.waypoint)]
        if not left and self._later:  # it may have been the turn of others then
            self._tried_again, self._later = self._tried_again + self._later, []
            return self._best(frontiers, scores_of, position, config)
        self.offered, self.scores = left, np.zeros(0)
        if not left:
            return None
        waypoints = np.array([frontier.waypoint for frontier in left])
        away = np.hypot(*(waypoints - position).T)
        self.scores = scores_of(waypoints, away)
        best = self.scores.max()
        tied = np.flatnonzero(self.scores >= best - config.tie * abs(best))
        chosen = int(tied[np.argmin(away[tied])])
        if self._kept is not None:
            last = int(np.argmin(np.hypot(*(waypoints - self._kept).T)))
            lead = best - self.scores[last]
            if self.is_same(waypoints[last], self._kept) and lead <= config.margin * abs(best):
                chosen = last
        if self._note(waypoints[chosen], position):
            return left[chosen]
        return self._best(frontiers, scores_of, position, config)

    def drop(self, waypoint) -> None:
        """Never choose a frontier there again: it cannot be reached."""
        self._dropped.append(np.asarray(waypoint, float))
        self._kept = None

    def is_same(self, one, other) -> bool:
        """Whether two waypoints (2,) [m] are of one frontier, that grew or shrank."""
        return bool(np.hypot(*(one - other)) <= self.config.same)

    def _note(self, waypoint, here) -> bool:
        """Whether the choice may be approached; not if the robot has come to no new place for long.

        Then it waits until no other is left; the second time it is dropped. The way may lead away from it at first.
        Others chosen in between, now and then, do not start that anew.
        """
        self._kept = waypoint
        self._choices += 1
        self._trials = [trial for trial in self._trials if self._choices - trial.latest <= self.config.patience]
        trial = next((trial for trial in self._trials if self.is_same(waypoint, trial.waypoint)), None)
        if trial is None:
            self._trials.append(trial := _Trial(waypoint))
        trial.waypoint, trial.latest = waypoint, self._choices
        if all(np.hypot(*(here - place)) >= self.config.progress for place in trial.been):
            trial.been.append(here)
            trial.stalled = 0
        else:
            trial.stalled += 1
        if trial.stalled <= self.config.patience:
            return True
        if self._is_in(self._tried_again, waypoint):
            self.drop(waypoint)
        else:
            self._later.append(waypoint)
            self._kept, self._trials = None, []  # the others may have stalled because of this one
        return False

    def _is_in(self, places: list[np.ndarray], waypoint) -> bool:
        return any(self.is_same(waypoint, other) for other in places)
