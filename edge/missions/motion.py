"""Steps that missions share: turn, and drive somewhere. Each is a story; `yield from` it."""

from dataclasses import dataclass

import numpy as np

from edge.mapping.frontiers import reachable
from edge.missions.mission import Story, until
from edge.observation import STOP, Twist
from edge.planning.mpepc import Mpepc, MpepcConfig
from edge.planning.standpoint import standpoint
from edge.planning.theta_star import ThetaStarConfig, plan
from edge.planning.trajectory_cost import CostConfig
from edge.pose import wrap
from edge.robot import Robot


@dataclass(frozen=True)
class MotionConfig:
    """How a turn ends and when a drive is given up."""

    turn_gain: float = 2.5  # 1/s
    turn_limit: float = 1.0  # rad/s; faster smears the picture and the scan
    turn_tolerance: float = np.radians(2.0)  # rad
    turn_progress: float = 0.05  # rad; a turn that gains less in `patience` is given up: a wheel is blocked
    margin: float = 0.07  # m kept beyond the robot's radius where the way is wide enough
    replan_every: float = 1.0  # s; the map grows while the robot drives
    progress: float = 0.10  # m; less than this in `patience` means that the robot is stuck
    detour: float = 1.0  # m that the way gets longer when a door was shut, or a chair put in it
    detours: int = 3  # of a drive; ways that change for ever lead nowhere
    patience: float = 6.0  # s; a full turn at the end, where the way gets no shorter, takes 5 s
    stand: float = 2.5  # s that a lost robot stands, for two looks for its place, before it turns


CONFIG = MotionConfig()


def turn(robot: Robot, angle: float, config: MotionConfig = CONFIG) -> Story:
    """Turn in place by ``angle`` [rad], which may exceed a full turn; positive is left."""
    left, last = angle, robot.pose[2]
    least, moved = abs(angle), robot.stamp
    while abs(left) > config.turn_tolerance or abs(robot.twist[1]) > 0.1:
        if abs(left) < least - config.turn_progress:
            least, moved = abs(left), robot.stamp
        elif robot.stamp - moved > config.patience:
            return
        omega = np.clip(config.turn_gain * left, -config.turn_limit, config.turn_limit)
        yield Twist(0.0, float(omega))
        left -= float(wrap(robot.pose[2] - last))
        last = robot.pose[2]


def face(robot: Robot, heading: float) -> Story:
    """Turn in place, the short way, to ``heading`` [rad] in the map."""
    yield from turn(robot, float(wrap(heading - robot.pose[2])))


def face_place(robot: Robot, place) -> Story:
    """Turn in place towards ``place (2,)`` [m] in the map."""
    x, y = place - robot.pose[:2]
    yield from face(robot, float(np.arctan2(y, x)))


def locate(robot: Robot, config: MotionConfig = CONFIG) -> Story:
    """Let a lost robot find its place: it stands, then turns once around. Whether it knows where it is."""
    lost = robot.stamp
    while robot.localizer.lost and robot.stamp - lost < config.stand:
        yield STOP
    if robot.localizer.lost:
        yield from until(lambda: not robot.localizer.lost, turn(robot, 2 * np.pi))
    return not robot.localizer.lost


def route(robot: Robot, goal, near: float = 0.4, config: MotionConfig = CONFIG) -> np.ndarray | None:
    """Theta* path ``(K, 2)`` [m] from the robot to ``goal (2,)``, or to within ``near`` [m] of it if it is blocked.

    It keeps a margin from obstacles if there is room for one. None when there is no way.
    """
    clearance, ends = robot.grid.clearance(), ThetaStarConfig(goal_tolerance=near)
    for radius in (robot.config.radius + config.margin, robot.config.radius):
        path = plan(robot.grid.traversable(radius), robot.grid.frame, robot.pose[:2], goal, clearance, ends)
        if path is not None:
            return path
    return None


def controller_for(robot: Robot) -> Mpepc:
    """Who steers this body, by this camera."""
    return Mpepc(MpepcConfig(cost=CostConfig(radius=robot.config.radius)), robot.camera)


def steer(robot: Robot, controller: Mpepc, path: np.ndarray | None, **goal) -> Twist:
    """The next command of ``controller`` along ``path (K, 2)``, given all that the robot knows; see ``Mpepc.step``."""
    around = {"bumper": robot.bumper, "movers": robot.movers.followed}
    return controller.step(robot.pose, robot.twist, path, robot.grid.clearance(), robot.grid.frame, **around, **goal)


def drive(robot: Robot, goal, heading: float | None = None, config: MotionConfig = CONFIG) -> Story:
    """Drive to ``goal (2,)`` [m] and, if given, turn to ``heading`` [rad]; True when there, False when it cannot be."""
    controller = controller_for(robot)
    path, planned = None, -np.inf
    nearest, moved, detours = np.inf, robot.stamp, config.detours
    while True:
        if robot.localizer.lost:
            if not (yield from locate(robot)):
                return False
            nearest, moved, planned = np.inf, robot.stamp, -np.inf
        if robot.stamp - planned >= config.replan_every:
            path, planned = route(robot, goal, config=config), robot.stamp
            if path is None:
                return False
        twist = steer(robot, controller, path, goal_heading=heading)
        if controller.arrived:
            yield STOP
            return True
        way = length(path)
        if way > nearest + config.detour and detours:
            nearest, moved, detours = way, robot.stamp, detours - 1
        elif way < nearest - config.progress:
            nearest, moved = way, robot.stamp
        elif robot.movers.anybody:
            moved = robot.stamp  # it waits, or goes round
        elif robot.stamp - moved > config.patience:
            return False
        yield twist


def look_from_near(robot: Robot, place, near: float) -> Story:
    """Drive to where ``place (2,)`` [m] is well seen from within ``near`` [m], as far as the map can tell; face it."""
    grid = robot.grid
    ground = reachable(grid, robot.pose, robot.config.radius)
    stand = standpoint(place, robot.pose, near, ground, grid.occupied, grid.frame)
    if stand is not None:
        yield from drive(robot, stand)
    yield from face_place(robot, place)


def length(path) -> float:
    """Length [m] of a polyline ``(K, 2)``."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())
