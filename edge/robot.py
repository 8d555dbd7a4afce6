"""What the robot knows, and how one observation changes it: where it is, what is free, what it has seen."""

import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel
from edge.jpeg import jpeg
from edge.localization.localizer import Localizer
from edge.localization.loop_closure import LoopCloser
from edge.mapping.coverage import CameraCoverage
from edge.mapping.occupancy import OccupancyGrid
from edge.mapping.view_fan import farthest
from edge.mapping.warp import carried_pose
from edge.memory.nodes import COLUMNS
from edge.memory.scan_bytes import pack
from edge.memory.store import Vlpg
from edge.observation import LaserScan, Observation, RgbdFrame
from edge.perception.close_look import look_closely, to_remember
from edge.perception.encoder import View
from edge.perception.movers import MoverTracker
from edge.pose import between, has_moved

DRIVING = 0.03  # m/s; what is measured of a robot that stands is less


@dataclass(frozen=True)
class RobotConfig:
    """The body, and what is worth remembering."""

    radius: float = 0.18  # m, [U] Sec. V
    seek_every: float = 1.0  # s between a lost robot's looks for its place, each of a tenth of a second or more
    candidate_distance: float = 0.10  # m; [V] offers a view every 100 ms, but from the same pose it tells nothing new
    candidate_angle: float = np.radians(6.0)  # rad
    keyframe_quality: int = 75  # of the JPEG that a node keeps for `vlpg reindex`; about 9 kB


class Robot:
    """The state that missions share. Missions read it; only ``perceive`` and the missions' own actions write it."""

    def __init__(self, encoder, memory: Vlpg, camera: CameraModel | None = None, config: RobotConfig | None = None):
        self.encoder = encoder
        self.memory = memory
        self.camera = camera or CameraModel()
        self.config = config or RobotConfig()
        self.grid = OccupancyGrid()
        self.localizer = Localizer()
        self.movers = MoverTracker()
        self.coverage = CameraCoverage()
        self.loops = LoopCloser(memory)
        self.stamp = 0.0  # s
        self.pose = np.zeros(3)
        self.twist = np.zeros(2)  # measured
        self.bumper = False
        self.distance = 0.0  # m driven
        self.frame: RgbdFrame | None = None  # the newest picture
        self._view: View | None = None  # what the image tower makes of it, once somebody has asked
        self._scan: LaserScan | None = None  # the newest lidar turn
        self._sought = -np.inf  # s, when a lost robot last looked for its place
        self._placed = False  # whether a scan was mapped since the last picture was looked at: so may the next one be
        self._offered = np.array([1e9, 1e9, 0.0])  # pose of the last view offered
        self.forgets = ""  # why the last view that is worth it was not remembered, for people

    def perceive(self, observation: Observation) -> None:
        """Notice who moves, localize, map, look, remember; the order matters, each uses what the one before found.

        Raises ValueError for a pose that is not finite or far off the map, or a picture that is not the camera's.
        """
        scan = observation.scan
        if scan is not None:
            self.movers.update(self.in_map(scan.odom), scan, self.grid)
            scan = self.movers.without_walkers(scan)
        pose = self.localizer.update(observation.odom, scan, self.grid)
        if scan is not None and self.localizer.lost and self._find_itself(scan):
            pose = self.pose = self.localizer.pose(observation.odom)
        self.distance += float(np.hypot(*(pose[:2] - self.pose[:2])))
        ahead = max(self.twist[0], observation.twist[0]) > DRIVING  # else it is not the front that touches
        self.stamp, self.pose = observation.stamp, pose
        self.twist, self.bumper = observation.twist, observation.bumper
        if scan is not None:
            self._scan = scan
            # The first one, and those that the localizer has placed: where the robot stands they tell nothing new.
            if self.localizer.fits or self.grid.unknown.all():
                self.grid.integrate_scan(self.in_map(scan.odom), scan)
                self._placed = True
        if observation.bumper and ahead and not self.localizer.lost:
            if not self.movers.touch(pose, self.config.radius):
                self.grid.integrate_contact(pose, self.config.radius)
        self.coverage.follow(self.grid.frame)
        self.frame, self._view = observation.frame, None
        if self.frame is not None and self._placed and self.localizer.sure:
            self._placed = False
            self._look(self.frame)

    def view(self) -> View:
        """The whole newest picture, through the image tower: the memory, and who looks for something, may both ask."""
        if self._view is None:
            self._view = self.encoder.encode_image(self.frame.rgb, self.camera.hfov)
        return self._view

    def look_closely(self) -> Iterator[View]:
        """The whole newest picture, then windows of it."""
        return look_closely(self.encoder, self.frame.rgb, self.view(), self.camera.hfov)

    def wake_in(self, grid: OccupancyGrid) -> None:
        """Wake up somewhere in the home that ``grid`` shows: lost, until a scan tells where. If it shows any."""
        self.grid, self.localizer, self.movers = grid, Localizer(lost=bool(grid.free.any())), MoverTracker()

    def in_map(self, odom):
        """A base pose of the odom frame, in the map frame."""
        return self.localizer.pose(odom)

    def correct(self, ids, poses, covariances) -> None:
        """Give nodes of the memory the ``poses (N, 3)`` and ``covariances (N, 3, 3)`` that the whole graph agrees on.

        The map, and the robot in it, move along. Raises what ``Vlpg.move`` and ``OccupancyGrid.moved`` do, and changes
        nothing then.
        """
        before, after = self.memory.poses(ids), np.asarray(poses, float)
        grid, column, row = self.grid.moved(before, after)
        self.memory.move(ids, after, covariances, grid.to_bytes())
        self.grid = grid
        self.movers = MoverTracker()  # where they were is not where they are in this map
        self.coverage.move(grid.frame, column, row)
        here = carried_pose(self.pose, before, after)
        self.localizer.move(self.pose, here)
        self.pose = here
        self._offered = carried_pose(self._offered, before, after)

    def _find_itself(self, scan: LaserScan) -> bool:
        """A lost robot looks for its place in the whole map, now and then; whether it has found it."""
        if abs(scan.stamp - self._sought) < self.config.seek_every:
            return False
        self._sought = scan.stamp
        found = self.localizer.relocalize(scan, self.grid)
        if found:
            self.memory.break_off()
        return found

    def _look(self, frame: RgbdFrame) -> None:
        pose = self.in_map(frame.odom)
        self.grid.integrate_depth(pose, frame.depth, self.camera, self.movers.discs)
        self.coverage.integrate(pose, frame.depth, self.camera, self.grid)
        moved = has_moved(self._offered, pose, self.config.candidate_distance, self.config.candidate_angle)
        if moved and not self.movers.hide(pose, self.camera):
            self._offered = pose
            self._remember(frame, pose)

    def _remember(self, frame: RgbdFrame, pose) -> None:
        """Offer a view to the memory, whose gate decides; often the whole picture tells that it is known."""
        if self.memory.knows(pose, self.view().vectors[0]):
            return
        vectors, bearings = to_remember(self.look_closely())
        keyframe = jpeg(frame.rgb, self.config.keyframe_quality)
        scan = None if self._scan is None else pack(self._scan, between(frame.odom, self._scan.odom))
        reach = farthest(frame.depth, COLUMNS)
        about = frame.stamp, pose, self.localizer.covariance, vectors, bearings, keyframe, scan, reach
        try:
            node = self.memory.add(*about)
            if node is not None:
                self.loops.consider(node)
        except sqlite3.Error as error:  # what is looked for can be found all the same
            self.forgets = f"views are not remembered ({error}); is the disk full?"
        else:
            self.forgets = ""
