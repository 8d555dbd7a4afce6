"""What a run left behind: ``report.json``, and beside it the pictures that it names. The page is made from this alone.

Positions are in the house frame [m] unless a field says otherwise; times are simulated seconds unless they say "wall".
"""

from pathlib import Path
from typing import Literal

import msgspec

Verdict = Literal["confirmed", "wrong", "no claim"]
Xy = tuple[float, float]
Xyt = tuple[float, float, float]

Offload = Literal["never", "auto", "host"]  # who encodes text: the robot, the host if it is there, only the host


class Thing(msgspec.Struct, frozen=True):
    """A true object of the house."""

    id: str
    name: str
    footprint: list[Xy]


class Home(msgspec.Struct, frozen=True):
    """The true house. ``start`` is the robot's map frame seen from the house frame."""

    name: str
    rooms: dict[str, list[Xy]]
    walls: list[tuple[Xy, Xy]]
    things: list[Thing]
    start: Xyt


class Map(msgspec.Struct, frozen=True):
    """A grid of the robot's as a grey picture, whose first row is lowest y."""

    picture: str
    shape: tuple[int, int]  # rows, cols
    origin: Xy  # map frame, lower-left corner
    resolution: float  # m


class Mapping(msgspec.Struct, frozen=True):
    """The tour that filled the memory."""

    complete: bool
    area: float  # m2 of free floor
    nodes: int
    distance: float  # m
    duration: float
    wall: float  # wall s
    path: list[Xy]  # as driven, by ground truth


class Hypothesis(msgspec.Struct, frozen=True):
    """A viewpoint, best first in its list, and the remembered views that speak for it."""

    pose: Xyt
    score: float
    members: list[Xyt]


class Replan(msgspec.Struct, frozen=True):
    """One step of a local search: how likely the object is where (grey 255 is 1), and the view chosen by that."""

    probability: Map
    pose: Xyt


class Search(msgspec.Struct, frozen=True):
    """One object asked for."""

    words: str
    status: str  # what the robot answered
    verdict: Verdict  # what the ground truth says to that
    remark: str  # the verdict in one sentence
    duration: float
    wall: float  # wall s
    distance: float  # m
    hypotheses: list[Hypothesis]
    replans: list[Replan]
    path: list[Xy]  # as driven, by ground truth
    pose: Xyt | None  # where the robot stopped, by its own map
    position: Xy | None  # where it says that the object is
    true_positions: list[Xy]  # of everything in the house that the words name
    angular_error: float | None  # rad between heading and the line of sight to the object's true centre
    visible: float  # share of the object's silhouette in the picture
    confidence: float | None  # that the robot states, of its claim or its best guess
    picture: str | None  # JPEG, the last one the camera took
    picture_size: tuple[int, int] | None  # width, height [px]
    box: tuple[float, float, float, float] | None  # x0, y0, x1, y1 [px]


class Process(msgspec.Struct, frozen=True):
    """Memory of one process [MB], sampled by the parent."""

    name: str
    peak_pss: float
    anonymous: float  # at the peak
    file_backed: float  # at the peak
    peak_rss: float
    times: list[float]  # wall s
    pss: list[float]


class Run(msgspec.Struct, frozen=True):
    """The whole record."""

    started: str  # local time, ISO 8601
    command: str
    seed: int
    speed: float
    offload: Offload
    machine: dict[str, str]
    versions: dict[str, str]
    wall: float  # wall s
    home: Home
    map: Map | None  # grey 0 is unknown, 128 free, 255 occupied
    mapping: Mapping | None
    nodes: list[Xyt]
    searches: list[Search]
    processes: list[Process]
    notes: list[str]  # what the reader must know, e.g. that time ran out

    def save(self, folder: Path) -> Path:
        """Write ``folder/report.json``."""
        path = Path(folder) / "report.json"
        path.write_bytes(msgspec.json.format(msgspec.json.encode(self), indent=1))
        return path

    @classmethod
    def load(cls, folder: Path) -> "Run":
        """Read ``folder/report.json``. Raises OSError, or msgspec.DecodeError when it is no such record."""
        return msgspec.json.decode((Path(folder) / "report.json").read_bytes(), type=cls)
