"""Collects what a run shows, in the house frame, for the report."""

import re
import shlex
import sys
import time
from datetime import datetime
from pathlib import Path

import cv2
import numpy as np

from edge.bench.usage import History
from edge.pose import compose, transform
from firmware_sim.house import House
from tools.demo.machine import machine, versions
from tools.demo.naming import named
from tools.demo.verdict import judgement
from tools.report.record import Home, Hypothesis, Map, Mapping, Offload, Process, Replan, Run, Search, Thing

STEP = 0.1  # m between points of a driven path


class Recorder:
    """Everything about one run; pictures go to ``folder`` as they come."""

    def __init__(self, house: House, seed: int, speed: float, offload: Offload, folder: Path):
        self.house, self.folder = house, folder
        self.notes: list[str] = []
        self.histories: dict[str, History] = {}
        self._seed, self._speed, self._offload = seed, speed, offload
        self._started, self._clock = datetime.now(), time.monotonic()
        self._path: list[tuple[float, float]] = []  # since the last mission ended
        self._mapping: Mapping | None = None
        self._searches: list[Search] = []
        self._map: Map | None = None
        self._nodes: list = []

    def trace(self, position) -> None:
        """The robot is truly at ``position (2,)``, or None while that is not known."""
        if position is not None and (not self._path or np.hypot(*np.subtract(position, self._path[-1])) >= STEP):
            self._path.append((round(float(position[0]), 3), round(float(position[1]), 3)))

    def mapped(self, status, complete: bool, duration: float, wall: float) -> Mapping:
        """Mapping ended with the robot's ``status``, after ``duration`` s of the base's clock and ``wall`` s."""
        path = self._end_path()
        self._mapping = Mapping(complete, status.area, status.nodes, status.distance, duration, wall, path)
        return self._mapping

    def searched(self, words: str, reply, truth, wall: float) -> Search:
        """The robot gave ``reply`` after ``wall`` [s]; ``truth`` is asked whether that is so."""
        truth.look([thing.id for thing in named(self.house, words)])
        judged = judgement(truth, words, reply.status == "found")
        number = len(self._searches) + 1
        picture, size = self._keep(reply.jpeg, f"{number}-{_slug(words)}.jpg")
        search = Search(
            words=words,
            status=reply.status,
            verdict=judged.verdict,
            remark=judged.remark,
            duration=reply.duration,
            wall=wall,
            distance=reply.distance,
            hypotheses=[
                Hypothesis(self._in_house(h.pose), h.score, [self._in_house(member) for member in h.members])
                for h in reply.hypotheses
            ],
            replans=[
                Replan(self._draw(replan, f"{number}-replan-{step}.png"), self._in_house(replan.pose))
                for step, replan in enumerate(reply.replans, 1)
            ],
            path=self._end_path(),
            pose=self._in_house(reply.pose),
            position=None if reply.position is None else self._in_house((*reply.position, 0.0))[:2],
            true_positions=judged.true_positions,
            angular_error=judged.angular_error,
            visible=judged.visible,
            confidence=reply.confidence,
            picture=picture,
            picture_size=size,
            box=reply.box,
        )
        self._searches.append(search)
        return search

    def know(self, grid, graph) -> None:
        """The robot's replies about its map and its pose graph."""
        cells = grid.cells.numpy()
        grey = np.select([cells < 0, cells >= 50], [0, 255], 128).astype(np.uint8)
        cv2.imwrite(str(self.folder / "map.png"), grey)
        self._map = Map("map.png", grey.shape, grid.origin, grid.resolution)
        self._nodes = [self._in_house(pose) for pose in graph.poses.numpy()]

    def finish(self) -> Run:
        """The record of all that happened until now."""
        return Run(
            started=self._started.isoformat(timespec="seconds"),
            command=shlex.join(["vlpg", *sys.argv[1:]]),
            seed=self._seed,
            speed=self._speed,
            offload=self._offload,
            machine=machine(),
            versions=versions(),
            wall=time.monotonic() - self._clock,
            home=self._home(),
            map=self._map,
            mapping=self._mapping,
            nodes=self._nodes,
            searches=self._searches,
            processes=[_process(name, history) for name, history in self.histories.items() if history.usages],
            notes=self.notes,
        )

    def _in_house(self, pose) -> tuple[float, float, float]:
        """A pose of the robot's map, whose origin is the dock, in the house."""
        return tuple(round(float(value), 4) for value in compose(self.house.start, pose))

    def _end_path(self):
        # The next path starts where this one ends.
        path, self._path = self._path, self._path[-1:]
        return path

    def _keep(self, jpeg: bytes | None, name: str):
        """File name and (width, height) of a picture, or None twice when there is none or it is damaged."""
        if not jpeg:
            return None, None
        picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        if picture is None:
            return None, None
        (self.folder / name).write_bytes(jpeg)
        return name, (picture.shape[1], picture.shape[0])

    def _draw(self, replan, name: str) -> Map:
        cells = replan.probability.numpy()
        cv2.imwrite(str(self.folder / name), cells)
        return Map(name, cells.shape, replan.origin, replan.resolution)

    def _home(self) -> Home:
        house = self.house
        return Home(
            name=house.name,
            rooms={room.name: [tuple(corner) for corner in room.polygon] for room in house.rooms},
            walls=[tuple(map(tuple, face)) for face in np.round(house.wall_segments(), 3).tolist()],
            things=[
                Thing(thing.id, thing.model.name, [tuple(p) for p in np.round(_outline(thing), 3).tolist()])
                for thing in house.objects.values()
            ],
            start=tuple(house.start.tolist()),
        )


def _outline(thing) -> np.ndarray:
    """Footprint ``(N, 2)`` in the house; the bounding box of a thing without one, such as a lamp on the ceiling."""
    if len(thing.footprint):
        return thing.footprint
    w, d = thing.model.size[0] / 2, thing.model.size[1] / 2
    return transform(thing.pose, np.array([(-w, -d), (w, -d), (w, d), (-w, d)]))


def _process(name: str, history: History) -> Process:
    peak = history.peak
    return Process(
        name=name,
        peak_pss=round(peak.pss, 2),
        anonymous=round(peak.anonymous, 2),
        file_backed=round(peak.file_backed, 2),
        peak_rss=round(max(usage.rss for usage in history.usages), 2),
        times=history.times,
        pss=[round(usage.pss, 2) for usage in history.usages],
    )


def _slug(words: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", words.lower()).strip("-")[:40] or "object"
