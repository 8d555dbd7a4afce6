"""Model predictive equilibrium point control (Park, Johnson, Kuipers 2012), the local planner of [V] Sec. III-D."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import ceil

import nlopt
import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.observation import STOP, Twist
from edge.perception.movers import Mover
from edge.planning.centring import CentringConfig, ImageTarget, centred, centring_cost, predict
from edge.planning.control_law import ControlLawConfig, RollOuts, egocentric, roll_out, target_pose
from edge.planning.path_progress import PathProgress, ProgressConfig, distance_to_go
from edge.planning.trajectory_cost import CostConfig, expected_cost, look_up, survival
from edge.pose import wrap

# Targets of the global start that do not depend on the path: r [m], θ, δ [rad], share of v_max.
_FAN = [(r, 0.0, delta, share) for r, share in ((1.2, 1.0), (0.6, 0.5)) for delta in (-1.2, -0.6, 0.0, 0.6, 1.2)]
# Ways back, for who stands in another's way: r [m], θ, δ [rad].
_BACK = [(r, 0.0, np.pi + aside) for r in (0.4, 1.0) for aside in (-0.6, 0.0, 0.6)]


@dataclass(frozen=True)
class MpepcConfig:
    """The search, and when the robot has arrived."""

    law: ControlLawConfig = field(default_factory=ControlLawConfig)
    cost: CostConfig = field(default_factory=CostConfig)
    progress: ProgressConfig = field(default_factory=ProgressConfig)
    centring: CentringConfig = field(default_factory=CentringConfig)
    period: float = 0.1  # s between commands
    evaluations: int = 12  # roll-outs of the refinement by COBYLA, 0.3 ms each; those before it cost as much
    lookahead: tuple[float, ...] = (0.4, 0.8, 1.4, 2.2)  # m along the path, targets of the global start
    settle: float = 0.05  # m from the path's end, where the robot stops and turns to the final heading
    tolerance: float = 0.08  # m; here it settles too once it can only come nearer by turning round
    heading_tolerance: float = np.radians(2.0)  # rad; [V] is served by 5°, the rest is for the localization
    lost: float = 0.20  # m, pushed or corrected this far from the end, it drives there again
    retreat: float = 0.4  # m/s backwards, out of the way of who comes; the map knows what the camera does not see
    clear_time: float = 1.0  # s that the chosen trajectory must be likely to survive, else the robot slows down
    stall_speed: float = 0.03  # m/s and a tenth of it in rad/s: slower is standing still
    back_off: float = 0.8  # s of slow reverse after the bumper was hit
    back_speed: float = 0.10  # m/s


class Mpepc:
    """Turns a path into velocity commands, one step every ``period``. Keeps the previous optimum; deterministic."""

    def __init__(self, config: MpepcConfig | None = None, camera: CameraModel | None = None):
        self.config = config or MpepcConfig()
        self.camera = camera or CameraModel()
        self.arrived = False  # whether the last step found the goal reached, or the object centred at its depth
        self.stalled = 0.0  # s that the robot has stood still without having arrived
        # Hard braking slips and shakes: odometry suffers, and so does the map. It is for who runs into the way.
        self._calm = replace(self.config.law, brake=self.config.law.acceleration)
        self._last = STOP
        self._optimum: np.ndarray | None = None  # (4,) target of the previous step: x, y, heading, v_max
        self._end: np.ndarray | None = None  # the goal of the previous step: x, y, heading or NaN
        self._settled = False
        self._backing = 0  # steps of reverse left

    def step(
        self,
        pose,
        twist,
        path: np.ndarray | None,
        clearance: np.ndarray,
        frame: GridFrame,
        goal_heading: float | None = None,
        target: ImageTarget | None = None,
        bumper: bool = False,
        movers: Sequence[Mover] = (),
    ) -> Twist:
        """The next command.

        ``pose (3,)`` and ``path (K, 2)`` [m] are in the map frame, ``twist (2,)`` is measured, ``clearance (R, C)`` [m]
        is each cell's distance to the nearest obstacle. At the end of the path the robot turns to ``goal_heading``, if
        given. With a ``target`` the object is kept in the middle of the picture and approached to ``centring.depth``;
        then ``path`` may be None. ``bumper`` tells that the robot touches something: it backs off. ``movers`` are what
        the map does not show; they are expected to go on as they move now.
        """
        if path is None and target is None:
            raise ValueError("Mpepc.step needs a path or a target to drive to; it got neither.")
        pose = np.asarray(pose, float)
        state = self._state(twist)
        if bumper:
            self._backing = ceil(self.config.back_off / self.config.period)
        if self._backing:
            return self._back_off(pose, clearance, frame)
        if target is None:
            goal = np.array([*path[-1], np.nan if goal_heading is None else goal_heading])
            self._note(goal)
            self._settle(pose, goal)
            if self._settled:
                return self._align(pose, state, goal[2])
        command = self._optimise(pose, state, path, clearance, frame, goal_heading, target, movers)
        standing = abs(command.v) < self.config.stall_speed and abs(command.omega) < 10 * self.config.stall_speed
        self.stalled = self.stalled + self.config.period if standing else 0.0
        self.arrived = target is not None and standing and self._served(target)
        return self._send(command)

    def _state(self, twist) -> np.ndarray:
        """Speeds that the command continues from: the commanded ones, as the measured lag, unless they disagree."""
        v, omega = (float(value) for value in twist)
        return np.clip([self._last.v, self._last.omega], [v - 0.15, omega - 0.6], [v + 0.15, omega + 0.6])

    def _send(self, command: Twist) -> Twist:
        self._last = command
        return command

    def _note(self, goal: np.ndarray) -> None:
        """A new goal is not reached yet, even if it is where the robot stands."""
        old, self._end = self._end, goal
        if old is not None:
            turned = 0.0 if np.isnan(goal[2]) and np.isnan(old[2]) else abs(wrap(goal[2] - old[2]))
            if np.hypot(*(goal - old)[:2]) <= self.config.settle and turned <= self.config.heading_tolerance:
                return
        self._settled, self.arrived, self.stalled = False, False, 0.0

    def _settle(self, pose: np.ndarray, goal: np.ndarray) -> None:
        """Decides whether the robot is at the end of the path, with hysteresis."""
        distance = float(np.hypot(*(goal[:2] - pose[:2])))
        line = np.arctan2(goal[1] - pose[1], goal[0] - pose[0])
        behind = abs(float(wrap(line - pose[2]))) > np.pi / 3
        if distance > self.config.lost:
            self._settled = self.arrived = False
        elif distance < self.config.settle or (distance < self.config.tolerance and behind):
            self._settled = True

    def _align(self, pose: np.ndarray, state: np.ndarray, heading: float) -> Twist:
        """Brakes, and turns on the spot to ``heading`` (NaN: any)."""
        law, error = self.config.law, 0.0 if np.isnan(heading) else float(wrap(heading - pose[2]))
        good = abs(error) <= self.config.heading_tolerance
        want = 0.0 if good else min(max(law.turn_gain * error, -law.turn_rate), law.turn_rate)
        command = self._limited(state, 0.0, want)
        self.arrived = good and abs(command.v) < 1e-6 and abs(command.omega) < 1e-6
        self.stalled = 0.0
        return self._send(command)

    def _limited(self, state: np.ndarray, v: float, omega: float) -> Twist:
        """The command nearest to (v, ω) that the accelerations allow within a period."""
        law = self.config.law
        reach = self.config.period * np.array([law.acceleration, law.angular_acceleration])
        v, omega = np.clip([v, omega], state - reach, state + reach)
        return Twist(float(v), float(omega))

    def _back_off(self, pose: np.ndarray, clearance: np.ndarray, frame: GridFrame) -> Twist:
        """Slow reverse as long as the map has room behind, whatever the map says about the front."""
        self._backing -= 1
        self._optimum, self.arrived, self._settled = None, False, False
        behind = pose[:2] - (self.config.cost.radius + 0.05) * np.array([np.cos(pose[2]), np.sin(pose[2])])
        room = look_up(clearance, frame, behind[0], behind[1]) > 0.05
        return self._send(Twist(-self.config.back_speed if room else 0.0, 0.0))

    def _served(self, target: ImageTarget) -> bool:
        """Whether the object is centred, and as near as it gets: at its depth, or as far as obstacles let the robot."""
        near = target.depth <= self.config.centring.depth + self.config.centring.depth_tolerance
        return centred(target, self.camera, self.config.centring) and (near or self.stalled >= 1.0)

    def _optimise(self, pose, state, path, clearance, frame, goal_heading, target, movers) -> Twist:
        config = self.config
        reach = config.law.v_max * config.law.dt * config.law.steps + 0.5
        progress = None if path is None else PathProgress(path, pose, reach)
        segment = config.law.dt * config.law.every
        retreat = config.retreat if movers else 0.0
        law = config.law if movers else self._calm

        def costs(out: RollOuts):
            alive = survival(out, clearance, frame, config.cost, movers, segment)
            gain = 0.0
            if progress is not None:
                gain = np.diff(distance_to_go(out, progress, goal_heading, config.progress), axis=1)
            if target is not None:
                e, depth = predict(target, out.v, out.omega, segment, self.camera)
                gain = gain + centring_cost(e, depth, self.camera, config.centring)
            return expected_cost(out, alive, gain, segment, config.cost)

        targets = self._candidates(pose, progress, goal_heading, target, retreat)
        out = roll_out(pose, state, targets, config.period, law)
        cost = costs(out)
        first = int(np.argmin(cost))
        best = [cost[first], targets[first], out.pick(first)]

        def objective(z, _gradient):
            candidate = np.array([*target_pose(pose, *z[:3]), z[3]])
            one = roll_out(pose, state, candidate[None], config.period, law)
            value = float(costs(one)[0])
            if value < best[0]:
                best[:] = value, candidate, one
            return value

        start = np.array([*egocentric(pose, targets[first, :3], config.law), targets[first, 3]])
        self._refine(objective, start, retreat)
        _, self._optimum, chosen = best
        v, omega = (float(value) for value in chosen.command[0])
        # Even the best drives into something: brake along its arc. Before what moves, to stand is one way of many.
        alive = survival(chosen, clearance, frame, config.cost)[0]
        if alive[round(config.clear_time / segment) - 1] < 0.5:
            slower = self._limited(state, 0.0, omega).v
            omega = omega * slower / v if v > 1e-3 else 0.0
            v, self._optimum = slower, None
        return Twist(v, omega)

    def _candidates(self, pose, progress: PathProgress | None, goal_heading, target, retreat: float) -> np.ndarray:
        """Targets ``(N, 4)`` of the global start: stand, turn, points on the way, a fixed fan, the previous optimum.

        And ways back, if there is a speed of ``retreat`` [m/s].
        """
        v_max = self.config.law.v_max
        rows = [[*pose, 0.0]]
        if progress is not None:
            ahead = progress.ahead(self.config.lookahead)
            end = np.array([*progress.end, ahead[-1, 2] if goal_heading is None else goal_heading])
            for on_path in (*ahead, end):
                rows += [[*on_path, v_max], [*on_path, 0.5 * v_max]]
            rows.append([*pose[:2], ahead[1, 2], 0.0])
        if target is not None:
            x, y, _ = self.camera.unproject(target.u, self.camera.centre[1], target.depth)
            away, bearing = np.hypot(x, y), np.arctan2(y, x)
            gap = max(away - self.config.centring.depth - self.camera.ahead, 0.0)
            for share in (0.0, 0.3, 0.6, 1.0):
                for speed in (v_max, 0.5 * v_max):
                    rows.append([*target_pose(pose, share * gap, 0.0, -bearing), speed])
        for r, theta, delta, share in _FAN:
            rows.append([*target_pose(pose, r, theta, delta), share * v_max])
        if retreat:
            rows += [[*target_pose(pose, *behind), -retreat] for behind in _BACK]
        if self._optimum is not None and self._optimum[3] >= -retreat:
            rows.append(self._optimum)
        return np.array(rows, float)

    def _refine(self, objective, z: np.ndarray, retreat: float) -> None:
        """Local search from ``z`` = (r, θ, δ, v_max). The objective keeps the best of all that is evaluated."""
        low, high = np.array([0.0, -np.pi, -np.pi, -retreat]), np.array([4.0, np.pi, np.pi, self.config.law.v_max])
        search = nlopt.opt(nlopt.LN_COBYLA, 4)
        search.set_lower_bounds(low)
        search.set_upper_bounds(high)
        search.set_min_objective(objective)
        search.set_initial_step([0.2, 0.3, 0.15, 0.1])
        search.set_maxeval(self.config.evaluations)
        try:
            search.optimize(np.clip(z, low, high))
        except nlopt.RoundoffLimited:
            pass  # it ends early; what it evaluated counts
