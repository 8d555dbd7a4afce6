"""The stand-in base as a process: runs the world at a steady pace, and speaks and listens as a real base would."""

import argparse
import logging
import threading
import time
from dataclasses import dataclass

import numpy as np

from edge.link import messages
from edge.link.alive import declare_alive
from edge.link.conversions import (
    camera_to_message,
    color_to_message,
    depth_to_message,
    header,
    odometry_to_message,
    scan_to_message,
    twist_from_message,
)
from edge.link.exchange import Inbox
from edge.link.messages import MessageError, decode
from edge.link.requests import TrueObject, Truth, TruthReply
from edge.link.session import LinkError, ToldToStop, add_link_arguments, key_root, link_config, open_session
from edge.link.topic import Topic, publisher
from edge.observation import Twist
from edge.process import stop_event
from firmware_sim.seed import seed

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class NodeConfig:
    """Pace and rates. Seconds are of simulated time where not said otherwise."""

    name: str = "robot1"  # key root
    speed: float = 1.0  # simulated seconds a second, at most
    period: float = 0.02  # s between odometry and IMU messages; 50 Hz, as usual for small bases
    slow_period: float = 1.0  # s between camera_info and battery messages
    # Faster than real time, a robot that thinks 50 ms would act on a world 50 ms * speed older. So while commands flow,
    # the world goes on for no more than `ahead` without one; a robot silent for `patience` is not waited for.
    ahead: float = 0.1  # s, the robot's control step
    patience: float = 1.0  # s of wall time


class Node:
    """Publishes what the base measures, and obeys ``cmd_vel``."""

    def __init__(self, session, world, config=None):
        """``world``: firmware_sim.world.World."""
        self.world, self.config = world, config or NodeConfig()
        name = self.config.name

        def stream(topic):
            return publisher(session, f"{name}/{topic}")

        self._odom, self._imu, self._scan = stream("odom"), stream("imu"), stream("scan")
        self._bumper = stream("bumper")
        self._color, self._depth = stream("camera/color/image/compressed"), stream("camera/depth/image_raw")
        self._info, self._battery = stream("camera/camera_info"), stream("battery_state")
        self._truth = stream("ground_truth/odom")
        self._wake = threading.Event()
        self._commands = Topic(session, f"{name}/cmd_vel", messages.Twist, wake=self._wake.set)
        self._inbox = Inbox(session, self._wake.set)
        self._inbox.on(f"{name}/ground_truth/objects", Truth, self._answer)
        self._next_slow = 0.0
        self._waits = False  # whether a robot sends commands that are worth waiting for
        self._last_command = 0.0  # s when the newest command arrived
        self._alive = declare_alive(session, f"{name}/alive/base")

    def run(self, stop):
        """Runs until the Event ``stop`` is set."""
        started, first = time.monotonic(), self.world.time
        while not stop.is_set():
            twist = self._command(stop)
            self._publish(self.world.step(twist, self.config.period))
            self._inbox.serve()
            due = started + (self.world.time - first) / self.config.speed
            behind = time.monotonic() - due
            if behind < 0:
                stop.wait(-behind)
            else:
                started += behind  # never catch up by running faster than asked
        self._alive.undeclare()

    def _command(self, stop):
        """The newest command, or None when none arrived since the last step."""
        twist = self._take_command()
        hurried = self.config.speed > 1.0 and self._waits
        if twist is None and hurried and self.world.time >= self._last_command + self.config.ahead - 1e-9:
            limit = time.monotonic() + self.config.patience
            while twist is None and time.monotonic() < limit and not stop.is_set():
                self._wake.wait(0.05)  # for a command or a request
                self._wake.clear()
                self._inbox.serve()
                twist = self._take_command()
            self._waits = twist is not None
        if twist is not None:
            self._waits, self._last_command = True, self.world.time
        return twist

    def _take_command(self):
        for payload in self._commands.take():  # at most one: the newest
            try:
                twist = twist_from_message(decode(messages.Twist, payload))
            except MessageError as error:
                log.warning("%s", error)
                continue
            if np.isfinite([twist.v, twist.omega]).all():
                return Twist(twist.v, twist.omega)
            log.warning("a command with NaN or infinity is ignored")
        return None

    def _publish(self, observation):
        world, stamp = self.world, observation.stamp
        # Odometry last: by then, all that was measured at its stamp is there.
        if observation.frame is not None:
            self._depth.put(depth_to_message(stamp, observation.frame.depth))
            self._color.put(color_to_message(stamp, observation.frame.rgb))
        if stamp >= self._next_slow:
            self._next_slow = stamp + self.config.slow_period
            self._info.put(camera_to_message(stamp, world.config.camera_model))
            self._battery.put(self._battery_message(stamp))
        if observation.scan is not None:
            self._scan.put(scan_to_message(observation.scan, world.config.scan_period))
        self._bumper.put(messages.Bool(observation.bumper))
        self._imu.put(self._imu_message(stamp))
        self._truth.put(odometry_to_message(stamp, world.truth, world.base.twist, frame="house"))
        covariance = world.odometry.covariance
        self._odom.put(odometry_to_message(stamp, observation.odom, observation.twist, covariance=covariance))

    def _imu_message(self, stamp):
        sample = self.world.imu
        message = messages.Imu(header(stamp, "base_link"))
        message.orientation_covariance[0] = -1.0  # as REP-145 asks of a unit without orientation
        message.angular_velocity.z = float(sample.turn_rate)
        message.linear_acceleration = messages.Vector3(*(float(a) for a in sample.acceleration), 9.81)
        return message

    def _battery_message(self, stamp):
        battery = self.world.battery
        return messages.BatteryState(
            header(stamp, "base_link"),
            voltage=battery.voltage,
            current=-battery.current,
            percentage=battery.charge,
            temperature=float("nan"),
            charge=float("nan"),
            capacity=float("nan"),
            design_capacity=float("nan"),
            power_supply_status=2,  # discharging
            present=True,
        )

    def _answer(self, request, exchange):
        """What is really where: for judges."""
        world, wanted = self.world, request.object.casefold()
        objects = [
            TrueObject(
                thing.id,
                thing.model.name,
                (float(thing.x), float(thing.y), float(thing.elevation)),
                float(world.visible_fraction(thing.id)),
            )
            for thing in world.house.objects.values()
            if not wanted
            or wanted in (name.casefold() for name in (thing.id, thing.model.id, thing.model.name))
            or wanted in thing.model.name.casefold().split()
        ]
        pose, start = (tuple(float(v) for v in p) for p in (world.truth, world.house.start))
        return TruthReply(world.time, pose, start, world.contacts, objects)


def main(arguments=None):
    """``python -m firmware_sim.node``: runs until SIGTERM or Ctrl-C."""
    parser = argparse.ArgumentParser(prog="vlpg sim", description="Run the simulated base in a furnished home.")
    parser.add_argument("--home", default="apartment", help="a home's name, its file, or generated:SEED")
    parser.add_argument("--seed", type=seed, default=0, help="seed of the sensors' noise (default: %(default)s)")
    parser.add_argument("--speed", type=_positive, default=1.0, help="simulated seconds a second, at most (default: 1)")
    parser.add_argument(
        "--name", type=key_root, default=NodeConfig.name, help="key root of this robot (default: %(default)s)"
    )
    parser.add_argument("--no-noise", action="store_true", help="perfect sensors, wheels and motors")
    add_link_arguments(parser)
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")

    from firmware_sim.furniture import FurnitureError
    from firmware_sim.home import load_home
    from firmware_sim.house import HouseError
    from firmware_sim.world import World, WorldConfig

    stop = stop_event()
    try:
        world = World(load_home(options.home), options.seed, WorldConfig(noise=not options.no_noise))
        with open_session(link_config(options), stop) as session:
            Node(session, world, NodeConfig(name=options.name, speed=options.speed)).run(stop)
    except ToldToStop:
        pass
    except (HouseError, FurnitureError, LinkError) as error:
        parser.exit(2, f"vlpg sim: {error}\n")


def _positive(text):
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


if __name__ == "__main__":
    main()
