"""What a robot observed on a mission, in a file: to be lived through again, here or on another processor.

Imports only what the robot has: it runs in the emulated system, too.
"""

import cv2
import numpy as np

from edge.observation import LaserScan, Observation, RgbdFrame

QUALITY = 95  # of the JPEGs; both sides decode the same ones
MILLIMETRES = 1000


def write(path, observations: list[Observation]) -> None:
    """In order. Pictures lose a little by JPEG, depths what is less than a millimetre."""
    arrays = {}
    for number, seen in enumerate(observations):
        name = f"{number:05d}"
        arrays[f"{name}.state"] = np.array([seen.stamp, *seen.odom, *seen.twist, seen.bumper])
        if seen.scan is not None:
            scan = seen.scan
            head = [scan.stamp, scan.angle_min, scan.angle_increment, scan.range_max, *scan.odom]
            arrays[f"{name}.scan"] = np.concatenate([head, scan.ranges])
        if seen.frame is not None:
            arrays[f"{name}.frame"] = np.array([seen.frame.stamp, *seen.frame.odom])
            arrays[f"{name}.rgb"] = _jpeg(seen.frame.rgb)
            arrays[f"{name}.depth"] = _millimetres(seen.frame.depth)
    np.savez_compressed(path, **arrays)


def read(path) -> list[Observation]:
    """What ``write`` wrote."""
    observations = []
    with np.load(path) as arrays:
        names = set(arrays.files)
        for number in range(sum(name.endswith(".state") for name in names)):
            name, scan, frame = f"{number:05d}", None, None
            stamp, x, y, theta, v, omega, bumper = arrays[f"{name}.state"].tolist()
            if f"{name}.scan" in names:
                values = arrays[f"{name}.scan"]
                scan = LaserScan(float(values[0]), values[7:], *values[1:4].tolist(), values[4:7])
            if f"{name}.frame" in names:
                values, depth = arrays[f"{name}.frame"], arrays[f"{name}.depth"].astype(np.float32) / MILLIMETRES
                frame = RgbdFrame(float(values[0]), _decoded(arrays[f"{name}.rgb"]), depth, values[1:])
            odom, twist = np.array([x, y, theta]), np.array([v, omega])
            observations.append(Observation(stamp, odom, twist, scan, frame, bool(bumper)))
    return observations


def _jpeg(rgb: np.ndarray) -> np.ndarray:
    return cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].ravel()


def _decoded(jpeg: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(cv2.imdecode(jpeg, cv2.IMREAD_COLOR)[..., ::-1])


def _millimetres(depth: np.ndarray) -> np.ndarray:
    return np.rint(np.nan_to_num(depth) * MILLIMETRES).astype(np.uint16)
