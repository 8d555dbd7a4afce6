"""Bodies of the requests and replies between robot, host and tools: msgspec structs in MessagePack.

Each struct validates what arrives. A reply of kind ``Refusal`` (zenoh's error reply) says what is wrong and where.
"""

import re
from math import prod
from typing import Annotated, Literal

import msgspec
import numpy as np
from msgspec import Meta

Text = Annotated[str, Meta(min_length=1, max_length=200, pattern=r"\S")]
KEY = r"^[^\s*$?#/]+(/[^\s*$?#/]+)*$"  # of zenoh, without wildcards
Key = Annotated[str, Meta(max_length=200, pattern=KEY)]
Count = Annotated[int, Meta(ge=1, le=1000)]
Position = tuple[float, float]  # x, y [m], map frame
Pose = tuple[float, float, float]  # x, y [m], theta [rad], map frame


class RequestError(ValueError):
    """A request that cannot be answered; ``field`` names the part at fault, or is empty."""

    def __init__(self, message, field=""):
        super().__init__(message)
        self.field = field


class Body(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Any request or reply. An unknown field is an error, so that a misspelt option is not silently ignored."""


class Array(Body):
    """A numpy array: raw little-endian bytes, row by row."""

    dtype: Literal["bool", "int8", "uint8", "int16", "uint16", "int32", "int64", "float32", "float64"]
    shape: Annotated[tuple[Annotated[int, Meta(ge=0)], ...], Meta(max_length=4)]
    data: bytes

    def __post_init__(self):
        expected = prod(self.shape) * np.dtype(self.dtype).itemsize
        if expected != len(self.data):
            raise ValueError(f"shape {self.shape} of {self.dtype} takes {expected} bytes, not {len(self.data)}")

    @classmethod
    def of(cls, array):
        """The wire form of a numpy array of one of the types above."""
        array = np.asarray(array)
        return cls(array.dtype.name, array.shape, array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes())

    def numpy(self):
        """The array; read-only, it shares the message's bytes."""
        return np.frombuffer(self.data, np.dtype(self.dtype).newbyteorder("<")).reshape(self.shape)


# On the robot: `<robot>/find`, `tour`, `cancel`, `status`, `map`, `graph`.


class Find(Body):
    """Find an object and drive to it. The reply comes when the search has ended, minutes later."""

    object: Text
    search_unknown: bool = False  # look at the best guesses too, and answer with the best one
    explore: bool = False  # ask the pictures on the way instead of the memory, as in a home never seen before


class Hypothesis(Body):
    """A place where the object may be seen from: one cluster of the memory's hits."""

    pose: Pose
    score: float  # mean of the members, [0, 1]
    members: list[Pose]  # nodes that speak for it, turned to where their region looks


class Replan(Body):
    """One step of a local search: where the object may be, and where the robot went to look next."""

    probability: Array  # (rows, cols) uint8, 255 is 1
    origin: Position  # m, lower-left corner
    resolution: float  # m
    pose: Pose


class FindReply(Body):
    """How a search ended. What is None was not reached."""

    status: Literal["found", "not found", "not in memory", "timeout", "lost", "cancelled"]
    object: str
    pose: Pose  # of the robot
    duration: float  # s
    distance: float  # m driven
    hypotheses: list[Hypothesis]  # best first
    position: Position | None = None  # of the object, m
    bearing: float | None = None  # rad from the optical axis, left positive, when it was last seen
    depth: float | None = None  # m, likewise
    score: float | None = None  # of the detection, [0, 1]
    box: tuple[float, float, float, float] | None = None  # x0, y0, x1, y1 px in the picture
    jpeg: bytes | None = None  # the robot's last picture
    confidence: float | None = None  # probability that the object is there, or, if not found, at the best guess
    replans: list[Replan] = []  # of the local searches, in order


class Tour(Body):
    """Drive through the home once more and look at everything again. The reply comes when that has ended."""


class TourReply(Body):
    """How a tour ended. Cut short ("timeout", "lost"), what it has seen is remembered all the same."""

    status: Literal["complete", "timeout", "lost", "cancelled"]
    duration: float  # s
    distance: float  # m driven
    nodes: int  # in the memory


class Cancel(Body):
    """End the mission that runs; the robot stops."""


class CancelReply(Body):
    cancelled: bool  # False: there was nothing to cancel


class Status(Body):
    """How is the robot?"""


class StatusReply(Body):
    state: Literal["idle", "mapping", "finding"]
    stamp: float  # s, the base's clock
    pose: Pose
    nodes: int
    area: float  # m2 of free floor known
    viewed: float  # m2 of it that the camera has looked at
    mapped: bool  # whether the home has been mapped to the end
    distance: float  # m driven
    memory: float  # MB, PSS now
    peak_memory: float  # MB, highest PSS seen
    encoder: str
    offload: Literal["host", "never", "auto"]
    host_alive: bool
    step_time: float  # s, median of the last control steps
    late: int  # steps that took longer than the control period
    object: str = ""  # what it is looking for
    outcome: str = ""  # how the last mission ended
    problem: str = ""  # what is wrong, for people


class Map(Body):
    """The occupancy grid, please."""


class MapReply(Body):
    cells: Array  # (rows, cols) int8 as in ROS: -1 unknown, 0 free, 100 occupied
    origin: Position  # m, lower-left corner
    resolution: float  # m
    path: Array  # (N, 2) float32 m, where the robot drove


class Graph(Body):
    """The pose graph, please; with the vectors of nodes from ``vectors_from`` on, when given."""

    vectors_from: Annotated[int, Meta(ge=0)] | None = None


class Vectors(Body):
    """Embeddings of nodes, as the store keeps them: row i is ``data[i] * scales[i]``."""

    owners: Array  # (M,) int32 node ids
    data: Array  # (M, D) int8
    scales: Array  # (M,) float32
    bearings: Array  # (M,) float32 rad


class GraphReply(Body):
    ids: Array  # (N,) int64, the nodes that answer queries
    poses: Array  # (N, 3) float64
    edges: Array  # (E, 2) int64 ids
    encoder: str
    digest: str
    memory: str  # names the memory, and since when it is open; else its ids may mean other nodes
    vectors: Vectors | None = None


# On the host: `host/embed_text`, `search`, `optimize`.


class EmbedText(Body):
    """Prompts to unit vectors."""

    texts: Annotated[list[Annotated[str, Meta(max_length=500)]], Meta(min_length=1, max_length=64)]
    digest: str  # of the robot's encoder; another pair's vectors would be meaningless


class EmbedTextReply(Body):
    vectors: Array  # (N, D) float32


class Optimize(Body):
    """Which poses agree best with everything that was measured between the nodes?"""

    ids: Array  # (N,) int64
    poses: Array  # (N, 3) float64, as they are now
    edges: Array  # (E, 2) int64 ids
    transforms: Array  # (E, 3) float64, the second node seen from the first
    information: Array  # (E, 3, 3) float64
    trusted: Array  # (E,) bool; the others may be plain wrong


class OptimizeReply(Body):
    poses: Array  # (N, 3) float64
    covariances: Array  # (N, 3, 3) float64


class Search(Body):
    """Where has this robot seen that? Answered from the host's copy of its memory, even when the robot sleeps."""

    object: Text
    robot: Key = "robot1"
    k: Count = 50


class SearchReply(Body):
    ids: Array  # (K,) int64
    scores: Array  # (K,) float32 in [0, 1], [V] Eq. 2
    poses: Array  # (K, 3) float64, of the robot
    bearings: Array  # (K,) float32 rad from the robot's heading
    nodes: int  # in the copy
    fresh: bool  # whether the robot answered just now; else the copy is as old as its last answer


# In simulation only, for judges: `<robot>/ground_truth/objects`.


class Truth(Body):
    """What is really there? Tools may ask; missions must not."""

    object: str = ""  # matches ids, model names and words of them; empty: everything


class TrueObject(Body):
    id: str
    name: str
    position: tuple[float, float, float]  # m, house frame
    visible: float  # share of its silhouette in the robot's picture now


class TruthReply(Body):
    stamp: float  # s
    pose: Pose  # of the base, house frame
    start: Pose  # house frame; the robot's map has its origin here
    contacts: int
    objects: list[TrueObject]


class Refusal(Body):
    """Why a request was not answered."""

    message: str
    field: str = ""


_encode = msgspec.msgpack.Encoder().encode
_decoders = {}


def pack(body):
    """A struct to MessagePack."""
    return _encode(body)


def unpack(kind, payload):
    """MessagePack to a struct of ``kind``. Raises RequestError that names the field, e.g. ``poses.shape[1]``."""
    if kind not in _decoders:
        _decoders[kind] = msgspec.msgpack.Decoder(kind)
    try:
        return _decoders[kind].decode(payload)
    except msgspec.ValidationError as error:
        text, _, path = str(error).partition(" - at `$")
        field = path.rstrip("`").lstrip(".")
        named = re.search(r"field `(\w+)`", text)  # missing or unknown; the path is that of its owner
        if named:
            field = f"{field}.{named[1]}".lstrip(".")
        raise RequestError(f"{text}{f' in {field}' if field and not named else ''}", field) from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise RequestError(f"the body is not MessagePack ({error})") from error
