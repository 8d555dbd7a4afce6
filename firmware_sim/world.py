"""House, robot and sensors in lock-step: a command in, an observation out, deterministic from a seed."""

from dataclasses import dataclass, field, replace
from math import atan, tan

import numpy as np

from edge.camera import CameraModel
from edge.observation import LaserScan, Observation, RgbdFrame, Twist
from edge.pose import wrap
from firmware_sim.base import Base, BaseConfig
from firmware_sim.battery import Battery, BatteryConfig
from firmware_sim.firmware import Firmware, FirmwareConfig
from firmware_sim.house import House
from firmware_sim.imu import Imu, ImuConfig, ImuSample
from firmware_sim.lidar import Lidar, LidarConfig
from firmware_sim.odometry import Odometry, OdometryConfig
from firmware_sim.pedestrian import Figure, Pedestrian
from firmware_sim.placement import HouseError

POWER_UP = 2.0  # s at rest before the clock starts


@dataclass(frozen=True)
class WorldConfig:
    """What is simulated, and how often each sensor speaks."""

    camera: bool = True  # render pictures; without, 50 times real time and more
    noise: bool = True  # of every sensor, wheel and motor
    scan_period: float = 0.1  # s
    frame_period: float = 0.1  # s
    camera_model: CameraModel = field(default_factory=CameraModel)
    base: BaseConfig = field(default_factory=BaseConfig)
    firmware: FirmwareConfig = field(default_factory=FirmwareConfig)
    odometry: OdometryConfig = field(default_factory=OdometryConfig)
    imu: ImuConfig = field(default_factory=ImuConfig)
    lidar: LidarConfig = field(default_factory=LidarConfig)
    battery: BatteryConfig = field(default_factory=BatteryConfig)


class World:
    """One robot in one house. ``truth``, ``picture`` and ``visible_fraction`` are for judges, not for missions."""

    def __init__(self, house: House, seed: int = 0, config: WorldConfig | None = None, start=None):
        """``start (3,)`` in the house frame; default: the house's dock. Raises nothing once the house is valid."""
        self.house, self.config = house, config or WorldConfig()
        config = self.config
        # One stream a source of noise, so that switching one sensor off leaves the others as they were.
        streams = [np.random.default_rng(source) for source in np.random.SeedSequence(seed).spawn(3)]
        base_rng, imu_rng, lidar_rng = streams if config.noise else (None, None, None)
        self.base = Base(house, house.start if start is None else start, config.base, base_rng)
        chassis = (config.base.wheel_radius, config.base.wheel_separation, config.base.ticks_per_turn)
        self.firmware = Firmware(config.firmware, *chassis, config.base.top_speed)
        self.odometry = Odometry(config.odometry, *chassis, config.firmware.period)
        self._imu = Imu(config.imu, config.firmware.period, imu_rng)
        # The base has been on for a moment when the clock starts: at rest, the filter has learnt the gyro's bias.
        for _ in range(round(POWER_UP / config.firmware.period)):
            self.imu: ImuSample = self._imu.read(0.0, 0.0, (0.0, 0.0))
            self.odometry.update((0, 0), self.imu.turn_rate)
        self.battery = Battery(config.battery)
        self.lidar = Lidar(house, config.lidar, lidar_rng)
        self.pedestrian: Pedestrian | None = None
        self.picture = None
        self._seed = seed
        self._cameras = {}
        self._judged = None  # view, instances and object ids of the last picture
        self._tick = 0  # periods of the firmware so far
        self._physics_steps = round(config.firmware.period / config.base.physics_step)
        self._next_scan = self._next_frame = 0.0

    @property
    def time(self) -> float:
        """Simulated seconds since the start."""
        return self._tick * self.config.firmware.period

    @property
    def truth(self) -> np.ndarray:
        """True base pose ``(3,)`` in the house frame."""
        x, y, theta = self.base.pose
        return np.array([x, y, wrap(theta)])

    @property
    def contacts(self) -> int:
        """How often the robot has run into something."""
        return len(self.base.contacts)

    @property
    def object_ids(self) -> list[str]:
        """What the numbers in ``picture.instances`` mean."""
        return self._camera("robot", self.config.camera_model, self.config.noise).object_ids

    def admit(self, pedestrian: Pedestrian) -> None:
        """Let a person walk through the house, by this world's clock, instead of the one before."""
        self.pedestrian = pedestrian
        self.base.admit(pedestrian)

    def step(self, twist: Twist | None, dt: float = 0.1, look: bool = True) -> Observation:
        """Let ``dt`` seconds pass, a multiple of the firmware's period. None: no command arrives in this step.

        Without ``look`` no picture is taken. Raises ValueError for a ``dt`` that is not such a multiple.
        """
        period = self.config.firmware.period
        periods = round(dt / period)
        if periods < 1 or abs(periods * period - dt) > 1e-9:
            raise ValueError(f"dt is {dt} s; it must be a multiple of the firmware's {period} s")
        if twist is not None:
            self.firmware.command(twist, self.time)
        bumper = False
        for _ in range(periods):
            duties = self.firmware.update(self.base.ticks, self.time)
            heading = self.base.heading
            self.base.advance(duties, self._physics_steps, self.battery.voltage_ratio)
            self._tick += 1
            turn_rate = (self.base.heading - heading) / period  # the gyro averages over its sampling period
            self.imu = self._imu.read(self.time, turn_rate, self.base.acceleration)
            self.odometry.update(self.base.ticks, self.imu.turn_rate)
            self.battery.drain(self.base.effort, period)
            bumper |= self.base.touching
        odom = self.odometry.pose
        frame = self._frame(odom) if look else None
        return Observation(self.time, odom, self.odometry.twist, self._scan(odom), frame, bumper)

    def _scan(self, odom):
        if self.time < self._next_scan - 1e-9:
            return None
        self._next_scan = self.time + self.config.scan_period
        lidar = self.config.lidar
        ranges = self.lidar.scan(self.base.pose, self._figure())
        return LaserScan(self.time, ranges, lidar.angle_min, lidar.angle_increment, lidar.range_max, odom)

    def _frame(self, odom):
        if not self.config.camera or self.time < self._next_frame - 1e-9:
            return None
        self._next_frame = self.time + self.config.frame_period
        camera = self._camera("robot", self.config.camera_model, self.config.noise)
        self.picture = camera.render(self.truth, self._figure())
        self._judged = (self._view(self.truth), self.picture.instances, camera.object_ids)
        return RgbdFrame(self.time, self.picture.rgb, self.picture.depth, odom)

    def visible_fraction(self, object_id: str, pose=None) -> float:
        """Share of an object's whole silhouette that the robot's camera sees from ``pose (3,)``, by default now.

        The whole silhouette is the object alone, seen from the same place through a window three times as wide and
        high: what is cut off by the image's border or hidden behind something counts as not visible. Raises HouseError
        for an object that is not in the house.
        """
        if object_id not in self.house.objects:
            raise HouseError(f"there is no object '{object_id}' in {self.house.name}")
        pose = self.truth if pose is None else np.asarray(pose, float)
        model = self.config.camera_model
        wide = replace(model, width=3 * model.width, height=3 * model.height, hfov=2 * atan(3 * tan(model.hfov / 2)))
        whole = np.count_nonzero(self._camera("wide", wide, False).silhouette(pose, object_id))
        if whole == 0:
            return 0.0
        if self._judged is None or self._judged[0] != self._view(pose):
            judge = self._camera("judge", model, False)
            self._judged = (self._view(pose), judge.render(pose, self._figure()).instances, judge.object_ids)
        _, instances, object_ids = self._judged
        if object_id not in object_ids:
            return 0.0
        return min(1.0, np.count_nonzero(instances == object_ids.index(object_id)) / whole)

    def _view(self, pose):
        """What a picture depends on."""
        return (*pose.tolist(), self.house.revision, self._figure())

    def _figure(self) -> Figure | None:
        return None if self.pedestrian is None else self.pedestrian.figure(self.time)

    def _camera(self, role, model, noise):
        if role not in self._cameras:
            from firmware_sim.camera import Camera  # late: worlds without a camera need no sprites

            self._cameras[role] = Camera(self.house, model, self._seed, noise=noise)
        return self._cameras[role]
