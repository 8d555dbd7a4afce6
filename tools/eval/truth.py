"""Parts of the robot that know the truth: with one at a time in place, a table tells where to work next."""

import cv2
import numpy as np

from edge.localization.localizer import Localizer
from edge.missions.find_object import FindObject
from edge.perception.detection import Detection, Detector, DetectorConfig
from edge.planning.viewpoint import Viewpoint
from edge.pose import between, compose
from firmware_sim.world import World
from tools.eval.judge import VISIBLE_SHARE, instances_of
from tools.eval.oracle import OracleEncoder

# What is replaced: the encoder by true labels of what is in view, the pose by the true one, the detector's box and
# score by the object's own, and the choice of where to look from by a place that truly shows it.
TRUTHS = ("encoder", "pose", "detector", "planner")
FROM = 1.0, 4.0  # m from the object; nearer a level camera loses it, farther it is small


class TrueLocalizer(Localizer):
    """Knows where the robot is."""

    def __init__(self, world: World):
        super().__init__()
        self._world = world

    def update(self, odom, scan, grid):
        true = between(self._world.house.start, self._world.truth)
        self.move(self.pose(odom), true)
        self.fits = scan is not None
        return true


class TrueDetector(Detector):
    """Boxes from the simulator's instance buffer. Pictures must be the world's newest."""

    def __init__(self, world: World, encoder):
        super().__init__(encoder, DetectorConfig())
        self._world = world

    def detect(self, view, target, image_size):
        left, top, right, bottom = view.window or (0, 0, *image_size)
        part = self._world.picture.instances[top:bottom, left:right]
        ids = self._world.object_ids
        named = [ids.index(thing.id) for thing in instances_of(self._world.house, target.name) if thing.id in ids]
        pixels = [np.count_nonzero(part == number) for number in named]
        if max(pixels, default=0) < OracleEncoder.MIN_PIXELS:
            return None
        mask = part == named[int(np.argmax(pixels))]
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        box = float(left + x), float(top + y), float(left + x + width), float(top + y + height)
        return Detection(box, 1.0, mask[y : y + height, x : x + width])


class TrueDetection(FindObject):
    """All of it, with the true detector."""

    def __init__(self, world: World, *arguments):
        self._world = world
        super().__init__(*arguments)

    def recall(self):
        hypotheses = super().recall()
        self.spotter.detector = TrueDetector(self._world, self.robot.encoder)
        return hypotheses


class TrueViewpoint(FindObject):
    """All of it, told the best viewpoint that there is: the node, turned to the object, that shows most of it."""

    def __init__(self, world: World, *arguments):
        self._world = world
        super().__init__(*arguments)

    def recall(self):
        super().recall()  # for the detector's settings and the scores of the memory's hits
        world, nodes = self._world, self.robot.memory.poses(self.robot.memory.ids)
        best, most = [], VISIBLE_SHARE
        for thing in instances_of(world.house, self.target.name):
            place = between(world.house.start, thing.pose)[:2]
            offsets = place - nodes[:, :2]
            away = np.hypot(*offsets.T)
            for node in np.flatnonzero((away > FROM[0]) & (away < FROM[1])):
                pose = np.array([*nodes[node, :2], np.arctan2(*offsets[node, ::-1])])
                shown = world.visible_fraction(thing.id, compose(world.house.start, pose))
                if shown > most:
                    best, most = [Viewpoint(pose, 1.0, np.arange(len(self.places)), 1.0)], shown
        return best

    def remembered(self):
        return bool(self.hypotheses)


def finder(tour, target, search: bool, seed: int) -> FindObject:
    """VLPG-Nav with the part replaced that ``tour.truth`` names, if any; encoder and pose were so for the tour."""
    if tour.truth == "detector":
        return TrueDetection(tour.world, tour.robot, target, search, seed)
    if tour.truth == "planner":
        return TrueViewpoint(tour.world, tour.robot, target, search, seed)
    return FindObject(tour.robot, target, search, seed)
