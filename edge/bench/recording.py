"""What a robot observed while it mapped a home and looked for things in it: to be lived through again, anywhere.

A file of arrays one after the other, as ``numpy.save`` writes them: first what was asked, then each observation. It is
read from front to back, without an index, so that it costs the robot that is measured no memory.
"""

from collections.abc import Iterator
from pathlib import Path
from tokenize import TokenError

import cv2
import numpy as np

from edge.observation import LaserScan, Observation, RgbdFrame

FORMAT = "vlpg recording 1"
QUALITY = 95  # of the JPEGs; whoever compares two processors has both decode the same ones
MILLIMETRES = 1000


class RecordingError(ValueError):
    """A file that holds no recording; the message says so."""


def write(path, observations: list[Observation], questions=(), prompts=None) -> None:
    """Observations in order; pictures lose a little by JPEG, depths what is less than a millimetre.

    ``questions``: pairs of the number of an observation and the name of an object, which the robot was asked for just
    before it. ``prompts``: text to vector ``(D,)``, what a host answered when it was asked what they mean.
    """
    prompts = prompts or {}
    with open(path, "wb") as file:
        _save(file, np.array(FORMAT))
        _save(file, np.array([number for number, _ in questions], int))
        _save(file, np.array([name for _, name in questions], str))
        _save(file, np.array(list(prompts), str))
        _save(file, np.array(list(prompts.values()), np.float32))
        _save(file, np.array(len(observations)))
        for seen in observations:
            parts = seen.scan is not None, seen.frame is not None
            _save(file, np.array([*parts, seen.stamp, *seen.odom, *seen.twist, seen.bumper]))
            if seen.scan is not None:
                scan = seen.scan
                head = [scan.stamp, scan.angle_min, scan.angle_increment, scan.range_max, *scan.odom]
                _save(file, np.concatenate([head, scan.ranges]))
            if seen.frame is not None:
                frame = seen.frame
                _save(file, np.array([frame.stamp, *frame.odom]))
                _save(file, _encoded(".jpg", frame.rgb[..., ::-1], cv2.IMWRITE_JPEG_QUALITY, QUALITY))
                _save(file, _encoded(".png", np.rint(np.nan_to_num(frame.depth) * MILLIMETRES).astype(np.uint16)))


class Recording:
    """What ``write`` wrote. Iterating reads the observations one by one."""

    def __init__(self, path: Path):
        """Raises RecordingError when there is none in the file."""
        self._path = path
        try:
            file = open(path, "rb")
        except OSError as error:
            reason = f"{path} cannot be read ({error.strerror})"
            raise RecordingError(f"{reason}; make a recording with: vlpg bench record {path}") from None
        with file:
            if self._load(file).tolist() != FORMAT:
                raise self._damaged()
            asked, names, prompts = (self._load(file).tolist() for _ in range(3))
            self.questions: list[tuple[int, str]] = list(zip(asked, names))
            self.prompts: dict[str, np.ndarray] = dict(zip(prompts, self._load(file)))
            self._count = int(self._load(file))
            self._first = file.tell()

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Observation]:
        with open(self._path, "rb") as file:
            file.seek(self._first)
            for _ in range(self._count):
                yield self._observation(file)

    def _observation(self, file) -> Observation:
        has_scan, has_frame, stamp, x, y, theta, v, omega, bumper = self._load(file).tolist()
        scan = frame = None
        if has_scan:
            values = self._load(file)
            scan = LaserScan(float(values[0]), values[7:], *values[1:4].tolist(), values[4:7])
        if has_frame:
            values, rgb, depth = (self._load(file) for _ in range(3))
            rgb = cv2.cvtColor(cv2.imdecode(rgb, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
            depth = cv2.imdecode(depth, cv2.IMREAD_UNCHANGED).astype(np.float32) / MILLIMETRES
            frame = RgbdFrame(float(values[0]), rgb, depth, values[1:])
        return Observation(stamp, np.array([x, y, theta]), np.array([v, omega]), scan, frame, bool(bumper))

    def _load(self, file) -> np.ndarray:
        try:
            return np.lib.format.read_array(file)
        except (ValueError, EOFError, SyntaxError, TokenError, SystemError) as error:  # its head is Python's own syntax
            raise self._damaged() from error

    def _damaged(self) -> RecordingError:
        return RecordingError(f"{self._path} is no whole recording; make one with: vlpg bench record FILE")


def _save(file, array: np.ndarray) -> None:
    np.lib.format.write_array(file, array, allow_pickle=False)


def _encoded(form: str, picture: np.ndarray, *settings: int) -> np.ndarray:
    return cv2.imencode(form, np.ascontiguousarray(picture), settings)[1].ravel()
