"""The robot's body: two driven wheels under a disc, pushed through the house by pymunk, seen from above."""

from dataclasses import dataclass
from math import cos, exp, hypot, sin, sqrt

import numpy as np
import pymunk

from firmware_sim.pedestrian import Pedestrian
from firmware_sim.placement import ROBOT_RADIUS, is_obstacle


@dataclass(frozen=True, slots=True)
class Contact:
    """The robot has run into something, or a person into the robot."""

    time: float  # s
    person: bool  # else a wall or furniture
    speed: float  # m/s, the robot's own just before


@dataclass(frozen=True)
class BaseConfig:
    """The chassis; figures of a light two-wheeled platform about a metre tall."""

    radius: float = ROBOT_RADIUS  # m
    mass: float = 9.0  # kg; base, mast, board and battery
    wheel_radius: float = 0.05  # m
    wheel_separation: float = 0.28  # m
    top_speed: float = 20.0  # rad/s of a wheel at full duty and nominal voltage: 1.0 m/s, so that 0.6 leaves reserve
    motor_lag: float = 0.08  # s; geared DC motor with its load
    friction: float = 0.7  # of rubber on a house floor: what the wheels can push before they spin
    ticks_per_turn: int = 2048  # of a wheel; a magnetic encoder behind a gear
    scale_error: float = 0.004  # standard deviation, per wheel: tyre wear and load, constant over a run
    slip: float = 0.02  # standard deviation of the relative slip of a rolling wheel
    slip_time: float = 0.3  # s; correlation time of the slip: joints between tiles, carpet pile
    physics_step: float = 0.01  # s


class Base:
    """Wheels, body and the obstacles around it. Duties in, encoder ticks and motion out."""

    def __init__(self, house, start, config: BaseConfig, rng: np.random.Generator | None):
        """Stand at ``start (3,)``. ``rng`` draws wheel errors and slip; None makes wheels that grip perfectly."""
        self.house, self.config, self._rng = house, config, rng
        self.time = 0.0  # s
        self.contacts: list[Contact] = []
        self.touching = False
        self._last_touch: dict[bool, float] = {}  # s, of a person (True) and of anything else
        self._space = pymunk.Space()
        self._space.collision_slop = 0.001
        inertia = config.mass * config.radius**2 / 2
        self._body = pymunk.Body(config.mass, inertia)
        self._body.position, self._body.angle = (float(start[0]), float(start[1])), float(start[2])
        self._disc = pymunk.Circle(self._body, config.radius)
        self._disc.friction = 0.3
        self._space.add(self._body, self._disc)
        self._pedestrian: Pedestrian | None = None
        self._person: pymunk.Circle | None = None
        self._obstacles: list[pymunk.Shape] = []
        self._revision = None
        self._wheel_speed = [0.0, 0.0]  # rad/s, left and right
        self._wheel_angle = [0.0, 0.0]  # rad
        self._slip = [0.0, 0.0]
        scale = rng.normal(0.0, config.scale_error, 2) if rng is not None else (0.0, 0.0)
        self._rolling_radius = [config.wheel_radius * (1 + float(error)) for error in scale]
        self.acceleration = (0.0, 0.0)  # m/s^2, forward and left, over the last physics step
        self.effort = 0.0  # mean of the squared duties of the last physics step: what the motors draw

    @property
    def pose(self) -> np.ndarray:
        """True pose ``(3,)``; theta is not wrapped."""
        x, y = self._body.position
        return np.array([x, y, self._body.angle])

    @property
    def heading(self) -> float:
        """True heading [rad], not wrapped."""
        return self._body.angle

    @property
    def twist(self) -> tuple[float, float]:
        """True forward speed [m/s] and turn rate [rad/s]."""
        vx, vy = self._body.velocity
        return vx * cos(self._body.angle) + vy * sin(self._body.angle), self._body.angular_velocity

    @property
    def ticks(self) -> tuple[int, int]:
        """Encoder counts of the left and right wheel since the start."""
        per_radian = self.config.ticks_per_turn / (2 * np.pi)
        return int(self._wheel_angle[0] // (1 / per_radian)), int(self._wheel_angle[1] // (1 / per_radian))

    def admit(self, pedestrian: Pedestrian) -> None:
        """Let a person walk about, whom nothing stops, instead of the one before."""
        if self._person is not None:
            self._space.remove(self._person.body, self._person)
        self._pedestrian = pedestrian
        self._person = pymunk.Circle(pymunk.Body(body_type=pymunk.Body.KINEMATIC), pedestrian.radius)
        self._person.friction = 0.3
        self._space.add(self._person.body, self._person)

    def advance(self, duties: tuple[float, float], steps: int, voltage_ratio: float = 1.0) -> None:
        """Let the motors run for ``steps`` physics steps at ``duties`` in [-1, 1], left and right."""
        if self._revision != self.house.revision:
            self._rebuild_obstacles()
        for _ in range(steps):
            self._step(duties, voltage_ratio)

    def _step(self, duties, voltage_ratio):
        config, body = self.config, self._body
        dt = config.physics_step
        # Motor: first-order lag towards the speed that the duty would give without load.
        gain = 1 - exp(-dt / config.motor_lag)
        rolled = [0.0, 0.0]
        for side in (0, 1):
            goal = duties[side] * config.top_speed * voltage_ratio
            before = self._wheel_speed[side]
            speed = before + gain * (goal - before)
            self._wheel_speed[side] = speed
            self._wheel_angle[side] += (before + speed) / 2 * dt
            rolled[side] = speed * self._rolling_radius[side]
        if self._rng is not None:
            self._draw_slip(dt)
            rolled[0] *= 1 - self._slip[0]
            rolled[1] *= 1 - self._slip[1]
        # Tyres: pull the body to the motion that the wheels roll, as hard as friction lets them. pymunk moves the body
        # first and applies forces after, so what is asked for now rules the next step, whose middle lies 1.5 ahead.
        vx, vy = body.velocity
        turning = body.angular_velocity
        heading = body.angle + 1.5 * dt * turning
        c, s = cos(heading), sin(heading)
        want = (rolled[0] + rolled[1]) / 2
        turn = (rolled[1] - rolled[0]) / config.wheel_separation
        push_x, push_y = want * c - vx, want * s - vy
        push = hypot(push_x, push_y)
        limit = config.friction * 9.81 * dt
        grip = min(1.0, limit / push) if push > 1e-12 else 1.0
        body.force = (push_x * grip * config.mass / dt, push_y * grip * config.mass / dt)
        twist_limit = limit * config.wheel_separation / 2 * config.mass / body.moment
        body.torque = min(max(turn - turning, -twist_limit), twist_limit) * body.moment / dt
        if self._pedestrian is not None:
            self._walk(dt)
        self._space.step(dt)
        self._note_contact(hypot(vx, vy))
        after_x, after_y = body.velocity
        ax, ay = (after_x - vx) / dt, (after_y - vy) / dt
        self.acceleration = (ax * c + ay * s, -ax * s + ay * c)
        self.effort = (duties[0] ** 2 + duties[1] ** 2) / 2
        self.time += dt

    def _draw_slip(self, dt):
        """Ornstein-Uhlenbeck slip of each wheel."""
        keep = exp(-dt / self.config.slip_time)
        shake = self.config.slip * sqrt(1 - keep * keep)
        left, right = self._rng.standard_normal(2)
        self._slip[0] = keep * self._slip[0] + shake * float(left)
        self._slip[1] = keep * self._slip[1] + shake * float(right)

    def _walk(self, dt):
        """Put the person where they are now, at the speed that takes them to where they are next."""
        here, there = (self._pedestrian.position(time) for time in (self.time, self.time + dt))
        self._person.body.position, self._person.body.velocity = tuple(here), tuple((there - here) / dt)

    def _note_contact(self, speed):
        """Notes what touches the robot, which drove at ``speed`` [m/s]; within 0.5 s it is the same contact."""
        touched = set()
        self._body.each_arbiter(lambda arbiter: touched.add(self._person in arbiter.shapes))
        for person in sorted(touched):
            if self.time - self._last_touch.get(person, -np.inf) > 0.5:
                self.contacts.append(Contact(self.time, person, speed))
            self._last_touch[person] = self.time
        self.touching = bool(touched)

    def _rebuild_obstacles(self):
        """Wall bodies and footprints of all obstacles as static shapes."""
        self._space.remove(*self._obstacles)
        static = self._space.static_body
        footprints = [thing.footprint for thing in self.house.objects.values() if is_obstacle(thing)]
        self._obstacles = [
            pymunk.Poly(static, [tuple(corner) for corner in body.tolist()])
            for body in [*self.house.plan.wall_bodies, *footprints]
        ]
        for shape in self._obstacles:
            shape.friction = 0.3
        self._space.add(*self._obstacles)
        self._revision = self.house.revision
