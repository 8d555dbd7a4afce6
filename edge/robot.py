"""What the robot knows, and how one observation changes it: where it is, what is free, what it has seen."""

from dataclasses import dataclass

import numpy as np

from edge.camera import CameraModel
from edge.localization.localizer import Localizer
from edge.mapping.coverage import CameraCoverage
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg
from edge.observation import Observation, RgbdFrame
from edge.pose import compose


@dataclass(frozen=True)
class RobotConfig:
    """The body, as planners and maps need it."""

    radius: float = 0.18  # m, [U] Sec. V
    height: float = 1.0  # m; what stands higher does not block


class Robot:
    """The state that missions share. Missions read it; only ``perceive`` and the missions' own actions write it."""

    def __init__(self, encoder, memory: Vlpg, camera: CameraModel | None = None, config: RobotConfig | None = None):
        self.encoder = encoder
        self.memory = memory
        self.camera = camera or CameraModel()
        self.config = config or RobotConfig()
        self.grid = OccupancyGrid()
        self.localizer = Localizer()
        self.coverage = CameraCoverage()
        self.stamp = 0.0  # s
        self.pose = np.zeros(3)
        self.twist = np.zeros(2)  # measured
        self.bumper = False
        self.distance = 0.0  # m driven
        self.frame: RgbdFrame | None = None  # the newest picture
        self.view = None  # its embedding
        self.remembering = True  # whether new views become nodes

    def perceive(self, observation: Observation) -> None:
        """Localize, map, look and remember; the order matters, each uses what the one before found."""
        pose = self.localizer.update(observation.odom, observation.scan, self.grid)
        self.distance += float(np.hypot(*(pose[:2] - self.pose[:2])))
        self.stamp, self.pose = observation.stamp, pose
        self.twist, self.bumper = observation.twist, observation.bumper
        if observation.scan is not None and not self.localizer.lost:
            self.grid.integrate_scan(self.in_map(observation.scan.odom), observation.scan)
        self.coverage.follow(self.grid.frame)
        self.frame, self.view = observation.frame, None
        if self.frame is not None:
            self._look(self.frame)

    def in_map(self, odom):
        """A base pose of the odom frame, in the map frame."""
        return compose(self.localizer.map_from_odom, odom)

    def _look(self, frame: RgbdFrame) -> None:
        pose = self.in_map(frame.odom)
        self.grid.integrate_depth(pose, frame.depth, self.camera)
        self.coverage.integrate(pose, frame.depth, self.camera, self.grid.frame)
        self.view = self.encoder.encode_image(frame.rgb)
        if self.remembering:
            self.memory.add(frame.stamp, pose, self.localizer.covariance, self.view.vectors, self.view.bearings)
