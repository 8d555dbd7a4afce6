"""``vlpg demo``: three real processes, an unknown home, some words. Reads as what happens, top to bottom."""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from math import degrees
from pathlib import Path
from typing import get_args

from rich.console import Console

from edge.bench.usage import Sampler
from edge.link.exchange import NoAnswer
from edge.link.requests import RequestError
from edge.link.session import LinkConfig, LinkError, open_session
from firmware_sim.home import load_home
from tools.demo.naming import default_objects
from tools.demo.processes import ProcessDied, Supervisor, free_port, module
from tools.demo.progress import Display, TimeLeft
from tools.demo.recorder import Recorder
from tools.demo.truth import Truth
from tools.report.page import write_page
from tools.report.record import Offload
from tools.robot_client import Call, RobotClient

FAILED, INTERRUPTED = 1, 130  # exit codes
_STYLES = {"confirmed": "green", "wrong": "bold red", "no claim": "yellow"}


class DemoError(ValueError):
    """A demo that cannot be run as asked; the message says why."""


@dataclass(frozen=True)
class DemoConfig:
    """What to show, and how long it may take."""

    home: str = "apartment"
    objects: tuple[str, ...] = ()  # in words; none: those of tools.demo.naming
    search_unknown: bool = False  # go to the best guesses too, and answer with the best
    offload: Offload = "never"  # so that the memory shown is that of a robot with everything on board
    seed: int = 0
    speed: float = 8.0  # simulated s a s, at most; the simulator waits for a robot that cannot keep up
    out: Path = Path("runs")
    time_limit: float = 300.0  # wall s, all in all
    mapping_share: float = 0.6  # of it; then mapping is broken off, so that there is time left to find things
    start_limit: float = 40.0  # wall s until all three processes answer
    least_search: float = 12.0  # wall s; with less left, no further object is asked for
    share: float = 2.0  # of the time left for each remaining object: what one search may take; then it is called off
    reserve: float = 10.0  # wall s for the report and for stopping the processes


def run_demo(config: DemoConfig) -> int:
    """Run it, and return the exit code: 0, or 1 when a claim was wrong or a process failed, or 130 after Ctrl-C.

    Raises DemoError, HouseError or FurnitureError before anything is started.
    """
    if config.offload not in get_args(Offload):
        raise DemoError(f"--offload is one of {', '.join(get_args(Offload))}, not {config.offload}")
    if any(not words.strip() for words in config.objects):
        raise DemoError("an object to find needs a name, but --object was empty")
    house = load_home(config.home)
    console = Console()
    recorder = Recorder(house, config.seed, config.speed, config.offload, _new_folder(config.out))
    failed, interrupted = False, False
    try:
        with _terminable(), Supervisor(recorder.folder) as processes, Display(console) as display:
            Demo(config, recorder, processes, display).run()
    except (ProcessDied, NoAnswer, RequestError) as error:
        failed = True
        recorder.notes.append(str(error).splitlines()[0])
        console.print(str(error), style="red", highlight=False, markup=False, soft_wrap=True)
    except KeyboardInterrupt:
        interrupted = True
        recorder.notes.append("The run was interrupted.")
    run = recorder.finish()
    run.save(recorder.folder)
    page = write_page(run, recorder.folder)
    confirmed = sum(search.verdict == "confirmed" for search in run.searches)
    summary = f"{confirmed} of {len(run.searches)} found, in {run.wall:.0f} s of wall time. Report: {page}"
    console.print(summary, highlight=False, markup=False, soft_wrap=True)
    if interrupted:
        return INTERRUPTED
    return FAILED if failed or any(search.verdict == "wrong" for search in run.searches) else 0


class Demo:
    """The run itself."""

    def __init__(self, config: DemoConfig, recorder: Recorder, processes: Supervisor, display: Display):
        self.config, self.recorder, self.processes, self.display = config, recorder, processes, display
        self.ends = time.monotonic() + config.time_limit - config.reserve

    def run(self) -> None:
        """Raises ProcessDied when a process ends, NoAnswer when one hangs, RequestError when the robot refuses."""
        try:
            self.story()
        except NoAnswer:
            self.processes.watch(1.0)  # if it has died, that is what to tell
            raise

    def story(self) -> None:
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.start_base(endpoint)
        with self.session(endpoint) as session:
            self.robot, self.truth = RobotClient(session), Truth(session, self.recorder.house)
            self.start_robot_and_host(endpoint)
            pids = {child.name: child.pid for child in self.processes.children}
            with Sampler(pids) as memory:
                self.recorder.histories = memory.histories
                self.map_home()
                self.recorder.know(self.robot.map(), self.robot.graph())
                objects = self.config.objects or default_objects(self.recorder.house)
                for number, words in enumerate(objects):
                    left = self.ends - time.monotonic()
                    if left < self.config.least_search:
                        self.out_of_time(objects[number:])
                        break
                    self.find(words, min(left, self.config.share * left / (len(objects) - number)))
                self.recorder.know(self.robot.map(), self.robot.graph())  # it has gone on seeing

    def start_base(self, endpoint: str) -> None:
        config = self.config
        arguments = ("--home", config.home, "--seed", str(config.seed), "--speed", str(config.speed))
        self.processes.start("sim", module("firmware_sim.node", *arguments, "--listen", endpoint, *_LOOPBACK))

    def start_robot_and_host(self, endpoint: str) -> None:
        memory = str(self.recorder.folder / "home.vlpg")
        self.processes.start("host", module("host.node", "--connect", endpoint, *_LOOPBACK))
        arguments = ("--memory", memory, "--offload", self.config.offload, "--connect", endpoint, *_LOOPBACK)
        self.processes.start("robot", module("edge.node", *arguments))
        self.until("the robot", self.robot.answers)

    @contextmanager
    def session(self, endpoint: str) -> Iterator:
        """A session with the started base, as soon as it listens."""
        link = LinkConfig(connect=(endpoint,), mode="client", multicast_scouting=False)
        opened = []

        def listens() -> bool:
            try:
                opened.append(open_session(link))
            except LinkError:
                return False
            return True

        self.until("the simulated base", listens)
        with opened[0] as session:
            yield session

    def until(self, what: str, answers: Callable[[], bool]) -> None:
        """Wait for a process to come up."""
        limit = time.monotonic() + self.config.start_limit
        while not answers():
            self.display.show("starting", f"waiting for {what}")
            self.processes.watch(0.2)
            if time.monotonic() > limit:
                raise ProcessDied(f"{what} did not answer within {self.config.start_limit:.0f} s; see its log")

    def map_home(self) -> None:
        """Wait while the robot explores; it does so on its own."""
        started = time.monotonic()
        breaks_off = min(started + self.config.mapping_share * self.config.time_limit, self.ends)
        left, complete, began = TimeLeft(), True, 0.0  # s of the base's clock, which has run since it was started
        while (status := self.robot.status()).state == "mapping":
            now, began = time.monotonic(), began or status.stamp
            self.recorder.trace(self.truth.position())
            remaining = left.update(now, status.viewed, status.area)
            until_done = "" if remaining is None else f", about {remaining:.0f} s left"
            detail = f"{status.viewed:.1f} of {status.area:.1f} m² seen, {status.nodes} nodes{until_done}"
            self.display.show("mapping", detail, status.viewed / max(status.area, 1.0))
            if now > breaks_off and complete:
                complete = False
                self.recorder.notes.append("Mapping was broken off, so that there was time left to find things.")
                self.robot.cancel()
            self.processes.watch(0.2)
        if status.problem and not status.mapped and complete:
            raise RequestError(f"The robot stopped: {status.problem}.")
        spent = status.stamp - began, time.monotonic() - started
        mapping = self.recorder.mapped(status, complete and status.mapped, *spent)
        self.display.say(
            f"mapped     {mapping.area:.1f} m² of free floor, {mapping.nodes} nodes, {mapping.distance:.1f} m driven, "
            f"in {mapping.duration:.0f} s ({mapping.wall:.0f} s of wall time)"
        )

    def find(self, words: str, limit: float) -> None:
        """Ask for one object, wait for the answer for ``limit`` wall s, and compare it with the truth."""
        started = time.monotonic()
        answer = Call(self.robot.find, words, self.config.search_unknown)
        cancelled = False
        while not answer.done:
            self.recorder.trace(self.truth.position())
            self.display.show("finding", f"{words}, {time.monotonic() - started:.0f} s")
            if time.monotonic() - started > limit and not cancelled:
                cancelled = True
                self.robot.cancel()
                note = f"The search for {words} was called off after {limit:.0f} s for lack of time."
                self.recorder.notes.append(note)
            self.processes.watch(0.1)
        search = self.recorder.searched(words, answer.result(), self.truth, time.monotonic() - started)
        claimed = search.verdict != "no claim" and search.angular_error is not None
        error = f"{abs(degrees(search.angular_error)):.0f}° off, " if claimed else ""
        self.display.say(
            f"{search.status:<14} {search.words}: {search.duration:.0f} s, {search.distance:.1f} m, {error}"
            f"{search.verdict}. {search.remark}",
            _STYLES[search.verdict],
        )

    def out_of_time(self, objects) -> None:
        note = f"Time ran out: {', '.join(objects)} {'was' if len(objects) == 1 else 'were'} not asked for."
        self.recorder.notes.append(note)
        self.display.say(note, "yellow")


_LOOPBACK = ("--no-multicast-scouting",)


def _new_folder(out: Path) -> Path:
    """``out/<local time>``, made. Raises OSError when it cannot be."""
    folder = Path(out) / datetime.now().strftime("%Y-%m-%dT%H-%M-%S")
    folder.mkdir(parents=True)
    return folder


@contextmanager
def _terminable() -> Iterator[None]:
    """Within, SIGTERM unwinds the stack as Ctrl-C does, so that the children are stopped."""

    def interrupt(*_):
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)
