"""Looking for one thing: around, closely, from near. What all missions that find things share."""

from dataclasses import dataclass

import numpy as np

from edge.missions.centring import centre
from edge.missions.mission import Story
from edge.missions.motion import face, look_from_near
from edge.missions.sighting import Sighting, sight
from edge.observation import STOP
from edge.perception.close_look import look_closely
from edge.perception.detection import Detector
from edge.perception.prompts import Target
from edge.robot import Robot


@dataclass(frozen=True)
class SpotterConfig:
    """How long and how far to look."""

    certain: float = 0.9  # score of a sighting that needs no further look around
    sweep: float = np.radians(40)  # rad to either side; half a field of view
    near: float = 1.8  # m from an object, where it is looked for again before it is centred
    pictures: int = 5  # looked at while standing still; most must show the object


class Spotter:
    """A robot's eye for a target. Each of its actions is a story; `yield from` it."""

    def __init__(self, robot: Robot, target: Target, config: SpotterConfig | None = None):
        self.config = config or SpotterConfig()
        self.detector = Detector(robot.encoder)
        self.in_vain: list[np.ndarray] = []  # poses (3,) from which the target was looked for and not seen
        self._robot, self._target = robot, target

    def look(self) -> Story:
        """Look ahead, then to both sides until certain; the best ``Sighting`` that lasts, or None."""
        heading, best = self._robot.pose[2], None
        for side in (0.0, self.config.sweep, -self.config.sweep):
            yield from face(self._robot, heading + side)
            seen = yield from self.stare()
            if seen is not None and (best is None or seen.detection.score > best.detection.score):
                best = seen
            if best is not None and best.detection.score >= self.config.certain:
                break
        return best

    def stare(self) -> Story:
        """Stand still for some pictures and look closely; the last ``Sighting`` if most show the target, else None."""
        robot, sightings = self._robot, []
        for _ in range(self.config.pictures):
            yield STOP
            if robot.frame is not None:
                views = look_closely(robot.encoder, robot.frame.rgb, hfov=robot.camera.hfov)
                sightings.append(sight(robot, self.detector, self._target, views))
        seen = [sighting for sighting in sightings if sighting is not None]
        if len(seen) > len(sightings) / 2:
            return seen[-1]
        self.in_vain.append(robot.pose)
        return None

    def approach(self, sighting: Sighting) -> Story:
        """Go where the target is seen well, and centre it; the last ``Sighting``, or None when it is not there."""
        for place in (sighting.position, sighting.behind):
            if place is not None:
                yield from look_from_near(self._robot, place, self.config.near)
                seen = yield from self.look()
                centred = seen and (yield from centre(self._robot, self.detector, self._target, seen))
                if centred is not None:
                    return centred
        return None
