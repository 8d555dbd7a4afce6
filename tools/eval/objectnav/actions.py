"""The discrete actions of [U] Sec. V, carried out by the simulated base: motors, slip and walls are as ever."""

from dataclasses import dataclass
from math import radians
from typing import Literal

import numpy as np

from edge.observation import STOP, Observation, Twist
from edge.pose import between, wrap
from firmware_sim.world import World

Action = Literal["forward", "left", "right", "stop"]
FORWARD = 0.25  # m
TURN = radians(30.0)


@dataclass(frozen=True)
class ActorConfig:
    """How the base carries an action out, by its own odometry."""

    speed: float = 0.5  # m/s
    turn_rate: float = 1.8  # rad/s
    gain: float = 5.0  # 1/s
    distance: float = 0.01  # m, and
    angle: float = radians(1.0)  # rad from the end of the action count as there
    patience: int = 25  # control steps of 0.1 s that an action may take, and
    pushing: int = 5  # of them while the bumper is pressed: along a wall it slides on


class Actor:
    """Moves the robot of a ``world`` one action at a time; a picture is taken after each."""

    def __init__(self, world: World, config: ActorConfig | None = None):
        self.config = config or ActorConfig()
        self._world = world

    def act(self, action: Action, heed) -> Observation:
        """Carry out an action, as far as the way is clear; the last observation, with a picture.

        Each observation before it is given to ``heed(observation)``: the robot localizes and maps by its lidar on the
        way, too.
        """
        start, pushed = self._world.odometry.pose, 0
        observation = None
        for _ in range(self.config.patience):
            twist = self._twist(action, between(start, self._world.odometry.pose))
            if twist == STOP:
                break
            observation = self._world.step(twist, look=False)
            heed(observation)
            pushed += observation.bumper
            if pushed > self.config.pushing:
                break
        while observation is not None and abs(observation.twist).max() > 0.02:
            observation = self._world.step(STOP, look=False)
            heed(observation)
        return self._world.step(STOP)

    def _twist(self, action: Action, done) -> Twist:
        config = self.config
        if action == "forward":
            left = FORWARD - done[0]
            return Twist(min(config.gain * left, config.speed)) if left > config.distance else STOP
        if action == "stop":
            return STOP
        left = float(wrap((TURN if action == "left" else -TURN) - done[2]))
        if abs(left) <= config.angle:
            return STOP
        return Twist(0.0, float(np.clip(config.gain * left, -config.turn_rate, config.turn_rate)))
