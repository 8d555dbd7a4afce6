"""What close looks took for the object: an agent that must stop somewhere stops at the best of that."""

from dataclasses import dataclass

from edge.mapping.object_goal import ObjectGoal, surface
from edge.missions.exploration import Exploration
from edge.perception.close_look import window_at
from edge.perception.detection import Detector, DetectorConfig


@dataclass(frozen=True)
class CandidateConfig:
    """What a close look from near must say."""

    seen: float = 0.5  # two-prompt score: the object, rather than something else ([V] Sec. III-C)
    certain: float = 0.9  # that score, which settles where the object is


CONFIG = CandidateConfig()


@dataclass(frozen=True, slots=True)
class Candidate:
    """Something that a close look took for the object, where that look saw it."""

    goal: ObjectGoal
    score: float  # of that look
    confidence: float  # that it is the object


class CandidateExploration(Exploration):
    """An exploration that looks closely once at what it came near to, without driving around it."""

    def __init__(self, robot, *arguments):
        super().__init__(robot, *arguments)
        self.candidates: list[Candidate] = []
        self._closely = Detector(robot.encoder, DetectorConfig(min_score=CONFIG.seen))

    def look_closely(self) -> Candidate | None:
        """A closer look at the newest picture, four passes and one at what they show; None if the goal is not there.

        A look that is certain moves the goal to where it shows the object. Whatever it shows becomes a candidate.
        """
        robot, frame = self._robot, self._robot.frame
        rgb, hfov, (height, width) = frame.rgb, robot.camera.hfov, frame.depth.shape
        views, last = robot.look_closely(), None
        for _ in range(2):
            found = [self._closely.detect(view, self.target, (width, height)) for view in views]
            best = max((d for d in found if d is not None), key=lambda d: d.score, default=last)
            if best is None:
                return None
            views, last = [robot.encoder.encode_image(rgb, hfov, window_at(best.centre, width, height))], best
        seen = surface(best, frame.depth, robot.camera, robot.in_map(frame.odom), robot.grid)
        found, here = None, self.goal.is_at(seen.centroid)
        if not seen.vague:  # else it is not here, if anywhere that way
            found = Candidate(ObjectGoal(seen), best.score, robot.encoder.confidence(best.score, best.score))
            self.candidates.append(found)
        if best.score >= CONFIG.certain:
            if here:
                self.goal.update(seen)
            elif not self.is_refuted(seen.centroid):
                self.goal = ObjectGoal(seen)
        return found if here else None

    def is_settled(self) -> bool:
        """Whether a close look took the goal for the object."""
        return any(self.goal.is_at(candidate.goal.centroid) for candidate in self.candidates)

    @property
    def best(self) -> Candidate | None:
        """The most probable of what was looked at closely."""
        return max(self.candidates, key=lambda candidate: candidate.confidence, default=None)

    @property
    def guesses(self) -> list[ObjectGoal]:
        """Where it may be, likeliest first: what close looks took for it, then what resembled it in a picture.

        Of the latter, what was looked at in vain comes last.
        """
        looked = sorted(self.candidates, key=lambda candidate: -candidate.confidence)
        alike = sorted(self.alike, key=lambda alike: (self.is_refuted(alike.place), -alike.score))
        return [candidate.goal for candidate in looked] + [ObjectGoal(one.seen) for one in alike]
