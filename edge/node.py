"""The robot process: where threads, sockets and clocks meet the core. It wires; it decides nothing.

One thread runs the core: it answers requests between control steps, so nothing in the core needs a lock. Zenoh's own
threads only hand messages over.
"""

import argparse
import logging
import sqlite3
import statistics
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from edge.link import requests
from edge.link.alive import Watch, declare_alive
from edge.link.base import Base
from edge.link.exchange import Exchange, Inbox
from edge.link.offload import OffloadedEncoder
from edge.link.reports import areas, cancelled_reply, find_reply, graph_reply, map_reply, tour_reply
from edge.link.requests import RequestError
from edge.link.session import LinkError, ToldToStop, add_link_arguments, key_root, link_config, open_session
from edge.link.straighten import straighten
from edge.mapping.warp import carried
from edge.memory.database import StoreError
from edge.memory.store import Vlpg
from edge.observation import STOP
from edge.process import MemoryUse, cache_file, give_back_large_blocks, give_back_what_loading_took, stop_event
from edge.service import Service
from models.manifest import Manifest, ModelError, resolve

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class NodeConfig:
    """Time limits of the wiring."""

    name: str = "robot1"  # key root
    silent: float = 0.5  # s of wall time without odometry after which the robot is told to stop; five control steps
    gone: float = 2.0  # s likewise, after which it cannot begin anything; a simulation faster than time waits for 1 s
    save_every: float = 60.0  # s of the base's clock between saves: so much of what it saw a power cut costs
    step_limit: float = 0.1  # s that perception and planning may take, one control period
    path_step: float = 0.05  # m between the points of the driven path, a grid cell


@dataclass(frozen=True)
class Missions:
    """How missions are made. A mission has ``step(observation) -> Twist``, ``done`` and ``outcome``."""

    map_home: Callable  # (robot) -> mission
    find: Callable  # (robot, requests.Find) -> mission; raises ValueError for an object that cannot be looked for


class Node:
    """Runs missions of a robot on a base, and answers for it."""

    def __init__(self, session, robot, missions: Missions, mapped=False, config=None, wait=False):
        """``mapped``: whether the home is known. If not, the robot maps it first, unless it is to ``wait``."""
        self.config = config or NodeConfig()
        self.robot, self.missions, self.mapped = robot, missions, mapped
        self._session = session
        self._wake = threading.Event()
        self.base = Base(session, self.config.name, self._wake.set)
        self._inbox = Inbox(session, self._wake.set)
        for key, kind, handler in (
            ("find", requests.Find, self._find),
            ("tour", requests.Tour, self._tour),
            ("cancel", requests.Cancel, self._cancel),
            ("status", requests.Status, self._status),
            ("map", requests.Map, self._map),
            ("graph", requests.Graph, self._graph),
        ):
            self._inbox.on(f"{self.config.name}/{key}", kind, handler)
        self._mission = None if mapped or wait else missions.map_home(robot)
        self._state = "idle" if self._mission is None else "mapping"
        self._restarts = 0  # of the base, that were heeded
        self._asked_by: Exchange | None = None  # who waits for the mission to end
        self._object = ""  # what is being looked for
        self._started = self._driven = 0.0  # stamp and odometer when the mission began
        self._outcome = self._problem = self._unsaved = self._blind = ""
        self._frame = None  # the newest picture
        self._camera_known = False  # whether the base has announced its camera
        self._path = deque(maxlen=20_000)  # 1 km
        self._saved = -np.inf  # stamp
        self._steps = deque(maxlen=100)  # wall s
        self._late = 0
        self._memory = MemoryUse()
        self._hosts = Watch(session, "host/alive/*")
        self._alive = declare_alive(session, f"{self.config.name}/alive/edge")

    def run(self, stop: threading.Event, service: Service):
        """Works until ``stop`` is set, then stops the robot and saves the map."""
        try:
            while not stop.is_set():
                service.alive()
                self._wake.wait(0.1)
                self._wake.clear()
                self._inbox.serve()
                observation = self.base.observe()
                if observation is not None:
                    self._step(observation)
                elif self._mission is not None and self.base.age > self.config.silent:
                    self.base.command(STOP)
                self._memory.sample()
        finally:
            self.base.command(STOP)
            self._save()
            if self._asked_by is not None:
                self._asked_by.refuse("the robot process is shutting down")
            self._alive.undeclare()

    def _step(self, observation):
        started = time.perf_counter()
        if self.base.restarts > self._restarts:
            self._restarts = self.base.restarts
            self._fail("the base was restarted and its odometry began anew")
            self.robot.wake_in(self.robot.grid)
            self._saved = -np.inf  # that stamp was of the old clock
        try:
            if observation.frame is not None:
                self._frame = observation.frame
                if not self._knows_camera(observation.frame):
                    observation = replace(observation, frame=None)
            if self._mission is None:
                self.robot.perceive(observation)
            elif self.base.silent:  # half blind a mission would give up what is there; it waits
                self.robot.perceive(observation)
                self.base.command(STOP)
            else:
                self.base.command(self._mission.step(observation))
                if self._mission.done:
                    self._finish()
        except Exception as error:  # a fault of ours must not keep the robot moving, lose the map or end the process
            if str(error) not in self._problem:  # idle, it may come with every observation
                log.exception("a control step failed")
            self._fail(f"internal error: {error}")
            return
        self._follow()
        if observation.stamp - self._saved >= self.config.save_every:
            self._save(self._state == "mapping")
        self._steps.append(time.perf_counter() - started)
        self._late += self._steps[-1] > self.config.step_limit

    def _knows_camera(self, frame):
        """Whether the base has told what camera takes pictures of this size; others would be misread."""
        if self._camera_known and _takes(self.robot.camera, frame):
            return True
        camera = self.base.camera(self.robot.camera)
        if camera is None or not _takes(camera, frame):
            rows, cols = frame.depth.shape
            self._blind = f"there is no camera_info for pictures of {cols} x {rows}, so they are not looked at"
            return False
        self.robot.camera, self._camera_known, self._blind = camera, True, ""
        return True

    def _follow(self):
        here = self.robot.pose[:2]
        if not self._path or np.hypot(*(here - self._path[-1])) >= self.config.path_step:
            self._path.append(here.copy())

    def _finish(self):
        """The mission has ended by itself."""
        outcome = self._mission.outcome
        if self._state == "finding":
            self._outcome = outcome.status
            reply = find_reply(self._object, outcome, self.robot, self._frame)
        else:
            self.mapped |= outcome.complete
            self._straighten()
            reply = tour_reply(outcome, self.robot)
            self._outcome = "mapped" if outcome.complete else f"mapped in part: {reply.status}"
        if self._asked_by is not None:
            self._asked_by.reply(reply)
        self._end()

    def _straighten(self):
        """With a host at hand, let the whole graph decide where its nodes are."""
        if not self._hosts.alive or self.robot.encoder.mode == "never":
            return
        self.base.command(STOP)
        try:
            before, after = straighten(self._session, self.robot)
        except RequestError as error:
            log.warning("the graph was not straightened: %s", error)
            return
        except Exception:  # a fault of ours must not end the process; the map as it is will do
            log.exception("the graph was not straightened")
            return
        if len(before):
            log.info("the graph was straightened by up to %.2f m", np.hypot(*(after - before)[:, :2].T).max())
            self._path = deque(carried(np.array(self._path), before, after), self._path.maxlen)

    def _fail(self, problem):
        """Something is wrong: the mission ends, if there is one. The next may be luckier."""
        self._problem = problem
        if self._mission is None:
            return
        self._outcome = "failed"
        self.base.command(STOP)
        if self._asked_by is not None:
            self._asked_by.refuse(problem)
        self._end()

    def _end(self):
        self._mission = self._asked_by = None
        self._state, self._object = "idle", ""
        self._save()

    def _save(self, whole=True):
        """What was seen since the last time; the ``whole`` is with the map, which hardly changes once it is known."""
        self._saved, memory = self.robot.stamp, self.robot.memory
        try:
            if whole or self._unsaved:
                memory.save_map(self.robot.grid.to_bytes())
                if self._camera_known:
                    memory.note_camera(self.robot.camera.hfov)
                if self.mapped:
                    memory.mark_mapped()
            else:
                memory.flush()
            self._unsaved = ""
        except sqlite3.Error as error:
            self._unsaved = f"the memory cannot be saved ({error}); is the disk full?"
            log.error("%s", self._unsaved)

    def _find(self, request, exchange):
        self._be_ready()
        try:
            mission = self.missions.find(self.robot, request)
        except ValueError as error:
            raise RequestError(str(error), getattr(error, "field", "") or "object") from error
        self._begin(mission, "finding", exchange)
        self._object = request.object

    def _tour(self, request, exchange):
        self._be_ready()
        self._begin(self.missions.map_home(self.robot), "mapping", exchange)

    def _be_ready(self):
        """Raises RequestError when the robot cannot begin anything now."""
        if self._mission is not None:
            busy = f"looking for {self._object}" if self._object else "mapping its home"
            raise RequestError(f"the robot is {busy}; wait, or cancel that first")
        if self.base.age > self.config.gone:
            raise RequestError("the base sends no odometry; start it first")

    def _begin(self, mission, state, exchange):
        self._mission, self._state, self._asked_by, self._problem = mission, state, exchange, ""
        self._started, self._driven = self.robot.stamp, self.robot.distance

    def _cancel(self, request, exchange):
        if self._mission is None:
            return requests.CancelReply(False)
        self.base.command(STOP)
        robot = self.robot
        if self._asked_by is not None:
            spent = robot.stamp - self._started, robot.distance - self._driven
            if self._state == "finding":
                self._asked_by.reply(cancelled_reply(self._object, robot, self._frame, *spent))
            else:
                self._asked_by.reply(requests.TourReply("cancelled", *spent, len(robot.memory)))
        self._outcome = "cancelled"
        self._end()
        return requests.CancelReply(True)

    def _status(self, request, exchange):
        robot, encoder = self.robot, self.robot.encoder
        area, viewed = areas(robot)
        return requests.StatusReply(
            state=self._state,
            stamp=robot.stamp,
            pose=tuple(float(value) for value in robot.pose),
            nodes=len(robot.memory),
            area=area,
            viewed=viewed,
            mapped=self.mapped,
            distance=robot.distance,
            memory=self._memory.now,
            peak_memory=self._memory.peak,
            encoder=encoder.name,
            offload=encoder.mode,
            host_alive=bool(self._hosts.alive),
            step_time=statistics.median(self._steps) if self._steps else 0.0,
            late=self._late,
            object=self._object,
            outcome=self._outcome,
            problem="; ".join(filter(None, (self._problem, self._unsaved, self._missing() or self.base.problem))),
        )

    def _missing(self):
        """What the robot lacks to work now, for people; empty if nothing."""
        if self.base.age > self.config.gone:
            return "the base sends no odometry"
        if silent := self.base.silent:
            return silent
        if self.robot.forgets:
            return self.robot.forgets
        if self.robot.localizer.lost:
            return "it does not find its place in its map; take it where it has been, or map anew into another --memory"
        return self._blind

    def _map(self, request, exchange):
        return map_reply(self.robot.grid, list(self._path))

    def _graph(self, request, exchange):
        return graph_reply(self.robot.memory, self.robot.encoder, request.vectors_from)


def _takes(camera, frame):
    """Whether ``camera`` takes pictures as large as this one."""
    return frame.depth.shape == (camera.height, camera.width)


def main(arguments=None):
    """``python -m edge.node``: runs the robot until SIGTERM or Ctrl-C."""
    parser = argparse.ArgumentParser(prog="vlpg robot", description="Map the home it wakes up in, then find things.")
    parser.add_argument(
        "--name", type=key_root, default=NodeConfig.name, help="key root of this robot (default: %(default)s)"
    )
    parser.add_argument("--memory", type=Path, default="home.vlpg", help="the home's store (default: %(default)s)")
    parser.add_argument("--wait", action="store_true", help="do not map an unknown home; wait to be asked")
    parser.add_argument("--model", help="name or folder of the encoder (default: the shipped one)")
    parser.add_argument(
        "--offload", choices=["host", "never", "auto"], default="auto", help="who encodes text (default: %(default)s)"
    )
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="cores for the towers (default: 1)")
    add_link_arguments(parser)
    options = parser.parse_args(arguments)
    if options.threads < 1:
        parser.error("--threads must be at least 1")
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    try:
        _run(options)
    except ToldToStop:
        pass
    except (LinkError, StoreError, ModelError) as error:
        parser.exit(2, f"vlpg robot: {error}\n")


def _run(options):
    # Late: what the tests of the wiring, and a process that only fails, need not load.
    import cv2

    from edge.mapping.occupancy import OccupancyGrid
    from edge.missions.find_object import FindObject
    from edge.missions.map_home import MapHome
    from edge.perception.encoder import Encoder
    from edge.perception.prompts import Target
    from edge.perception.text import TextTower
    from edge.robot import Robot

    manifest = Manifest.load(resolve(options.model) if options.model else resolve())
    manifest.verify(text=options.offload != "host")
    images = Encoder(manifest, text=False, threads=options.threads)
    stop, service = stop_event(), Service()
    give_back_large_blocks()
    give_back_what_loading_took()
    cv2.setNumThreads(1)  # the other cores are the base's, and of who else lives on the board
    # The store first: that it is another encoder's is said whether or not anybody listens.
    with Vlpg.open(options.memory, images.name, images.digest, images.dim) as memory:
        service.ready()  # that nobody listens yet, to whom it is to connect, is no failure of its own
        with open_session(link_config(options), stop, service.alive) as session:
            tower, prompts = TextTower(manifest, options.threads), cache_file("prompts.db")
            encoder = OffloadedEncoder(session, images, options.offload, tower, prompts)
            robot = Robot(encoder, memory)
            saved = memory.load_map()
            if saved is not None:
                try:
                    robot.wake_in(OccupancyGrid.from_bytes(saved))
                except ValueError as error:
                    raise StoreError(f"{options.memory}: {error}") from error

            def find(robot, asked):
                target = Target.of(asked.object, encoder)
                if not asked.explore:
                    return FindObject(robot, target, asked.search_unknown)
                from edge.missions.explore_for_object import ExploreForObject  # late: few ask for it

                return ExploreForObject(robot, target)

            config = NodeConfig(name=options.name)
            node = Node(session, robot, Missions(MapHome, find), memory.mapped, config, options.wait)
            give_back_what_loading_took()
            node.run(stop, service)


if __name__ == "__main__":
    main()
