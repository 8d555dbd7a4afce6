"""Looking for one thing: around, closely, from near. What all missions that find things share."""

from dataclasses import dataclass
from random import Random

import numpy as np

from edge.mapping.frontiers import reachable
from edge.mapping.sight_line import mapped_depth
from edge.missions.centring import centre
from edge.missions.mission import Story
from edge.missions.motion import drive, face, face_place, look_from_near
from edge.missions.sighting import Sighting, sight
from edge.observation import STOP
from edge.perception.detection import Detector
from edge.perception.occlusion import hidden_share
from edge.perception.prompts import Target
from edge.planning.local_search import LocalSearch, Replan
from edge.robot import Robot


@dataclass(frozen=True)
class SpotterConfig:
    """How long and how far to look."""

    certain: float = 0.9  # score of a sighting that needs no further look around
    sweep: float = np.radians(40)  # rad to either side; half a field of view
    near: float = 1.8  # m from an object, where it is looked for again before it is centred
    pictures: int = 5  # looked at while standing still; most must show the object
    hidden: float = 0.12  # of an object's outline, at which something nearer begins: then it is looked at from aside
    extent: float = 0.6  # m around what shows of an object, within which the rest of it is


class Spotter:
    """A robot's eye for a target. Each of its actions is a story; `yield from` it."""

    def __init__(self, robot: Robot, target: Target, config: SpotterConfig | None = None):
        self.config = config or SpotterConfig()
        self.detector = Detector(robot.encoder)
        self.in_vain: list[np.ndarray] = []  # poses (3,) from which the target was looked for and not seen
        self.replans: list[Replan] = []  # of the searches for what is hidden, in order
        self._robot, self._target = robot, target

    def look(self) -> Story:
        """Look ahead, then to both sides until certain; face the best ``Sighting`` that lasts, if any; returns it."""
        heading, best = self._robot.pose[2], None
        for side in (0.0, self.config.sweep, -self.config.sweep):
            yield from face(self._robot, heading + side)
            seen = yield from self.stare()
            if seen is not None and (best is None or seen.detection.score > best.detection.score):
                best = seen
            if best is not None and best.detection.score >= self.config.certain:
                break
        if best is not seen:
            yield from face(self._robot, best.pose[2] + best.bearing)
        return best

    def stare(self) -> Story:
        """Stand still for some pictures and look closely; the last ``Sighting`` if most show the target, else None."""
        robot, sightings = self._robot, []
        while len(sightings) < self.config.pictures:
            yield STOP
            if robot.frame is not None:
                sightings.append(sight(robot, self.detector, self._target, robot.look_closely()))
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
                    return (yield from self.uncover(centred))
        return None

    def uncover(self, centred: Sighting) -> Story:
        """If something stands before what was ``centred``, look from where it hides less; the better ``Sighting``."""
        hidden = yield from self.hidden(centred)
        if hidden <= self.config.hidden:
            return centred
        robot, grid = self._robot, self._robot.grid
        search = LocalSearch(grid.occupied, grid.free, grid.frame, centred.position, [], [], robot.camera)
        search.expect(centred.position, self.config.extent)
        search.observed(robot.pose)
        ground = reachable(grid, robot.pose, robot.config.radius)
        pose = search.next_pose(robot.pose, ground, grid.clearance(), grid.frame, Random(0))
        if pose is not None:
            self.replans.append(Replan(search.frame, search.probability.copy(), pose))
            yield from drive(robot, pose[:2], heading=pose[2])
            seen = yield from self.stare()
            aside = seen and (yield from centre(robot, self.detector, self._target, seen))
            if aside is not None and (yield from self.hidden(aside)) < hidden:
                return aside
            yield from drive(robot, centred.pose[:2], heading=centred.pose[2])
            yield from face_place(robot, centred.position)  # the way back may have ended elsewhere
        return centred

    def hidden(self, centred: Sighting) -> Story:
        """Share of the outline of what was just ``centred`` at which something nearer begins."""
        robot = self._robot
        while robot.frame is None:
            yield STOP
        depth = robot.frame.depth
        pose, columns = robot.in_map(robot.frame.odom), np.arange(depth.shape[1])
        # What is too near, or too far, for the depth camera is as far as the map says.
        mapped = mapped_depth(robot.grid, robot.camera, pose, columns)
        return hidden_share(centred.detection, np.where(np.isfinite(depth) & (depth > 0), depth, mapped))
