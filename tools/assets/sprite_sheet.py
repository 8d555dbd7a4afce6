"""Pictures of one model from many directions in two sheets: colour with coverage, and relief.

A sheet has a row for each pitch and a column for each yaw. The relief is the depth behind the plane through the centre
of the bounding box, in 8 bits between the model's nearest and furthest point, at half the resolution, continued
outside the silhouette with the nearest value inside.
"""

from dataclasses import dataclass
from math import atan2, degrees, hypot, radians

import cv2
import numpy as np

from tools.assets.obj_model import Mesh
from tools.assets.rasterizer import axes, extent, render

YAWS = 16
CAMERA_HEIGHT = 0.88  # m
FOCAL = 194.0  # px: 320 px across 79 degrees
NEAR, FAR = 0.7, 3.0  # m, distances to the centre between which most looks at an object happen
ON_FURNITURE = 0.75  # m, highest base of a small thing that stands on furniture
SMALL = 0.7  # m, longest side of a thing that may stand on furniture
REACH = 0.6  # m, nearest the camera comes to an object's side
MAX_CELL = 200  # px; with QUALITY, keeps the pack of 150 models under 20 MB
QUALITY = 75  # WebP


@dataclass(frozen=True)
class SpriteSheet:
    """Encoded sheets and what is needed to read them."""

    colour: bytes  # WebP, RGBA, (pitches * height, yaws * width)
    relief: bytes  # WebP, grey, half as many pixels each way
    cell: tuple[int, int]  # width, height of one picture [px], even
    scale: float  # px per metre
    pitches: list[float]  # degrees
    relief_range: tuple[float, float]  # m at grey 0 and 255

    @property
    def layout(self) -> dict:
        """What the catalog says of the sheets."""
        return {
            "cell": self.cell, "scale": round(self.scale, 3), "yaws": YAWS,
            "pitches": self.pitches, "relief": [round(value, 4) for value in self.relief_range],
        }  # fmt: skip


def pitches(size: tuple[float, float, float], elevation: float | None) -> list[float]:
    """One to three pitches [degrees] that cover how a camera at CAMERA_HEIGHT looks down at (or up to) the thing."""
    lowest = (elevation or 0.0) + size[2] / 2
    highest = lowest + (ON_FURNITURE if max(size) <= SMALL and elevation is None else 0.0)
    angles = [degrees(atan2(CAMERA_HEIGHT - z, d)) for z in (lowest, highest) for d in (NEAR, FAR)]
    low, span = min(angles), max(angles) - min(angles)
    count = 1 if span < 8 else 2 if span < 24 else 3
    return [round(low + span * (2 * i + 1) / (2 * count), 1) for i in range(count)]


def draw_sheet(mesh: Mesh, elevation: float | None) -> SpriteSheet:
    """Render and encode all pictures of ``mesh``, which hangs at ``elevation`` [m] or stands (None)."""
    rows = pitches(mesh.size, elevation)
    views = [(2 * np.pi * column / YAWS - np.pi, radians(row)) for row in rows for column in range(YAWS)]
    half = np.array([extent(mesh, *view) for view in views]).max(0)
    scale = FOCAL / (REACH + hypot(*mesh.size[:2]) / 2)
    scale = min(scale, (MAX_CELL - 4) / (2 * half.max()))
    width, height = (int(np.ceil(value * scale)) * 2 + 4 for value in half)
    reach = (mesh.corners.reshape(-1, 3) - [0, 0, mesh.size[2] / 2]) @ np.stack([axes(*v)[2] for v in views]).T
    near, far = float(reach.min()), float(reach.max()) + 1e-3
    colour, relief = [], []
    for yaw, pitch in views:
        view = render(mesh, yaw, pitch, (width, height), scale)
        solid = view.rgba[..., 3] > 0
        source = _nearest(solid)
        filled = np.dstack([view.rgba[..., :3].reshape(-1, 3)[source], view.rgba[..., 3]])
        depth = _nearest_known(view.depth)[1::2, 1::2]
        colour.append(filled)
        relief.append(np.clip((depth - near) / (far - near) * 255, 0, 255).round().astype(np.uint8))
    sheet = cv2.cvtColor(_tile(colour, len(rows)), cv2.COLOR_RGBA2BGRA)
    encoded = cv2.imencode(".webp", sheet, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])[1].tobytes()
    grey = cv2.imencode(".webp", _tile(relief, len(rows)), [cv2.IMWRITE_WEBP_QUALITY, 101])[1].tobytes()
    return SpriteSheet(encoded, grey, (width, height), scale, rows, (near, far))


def _tile(cells: list[np.ndarray], rows: int) -> np.ndarray:
    columns = len(cells) // rows
    return np.vstack([np.hstack(cells[row * columns : (row + 1) * columns]) for row in range(rows)])


def _nearest(known: np.ndarray) -> np.ndarray:
    """For each pixel (h, w) the flat index of the nearest pixel that is ``known``."""
    _, labels = cv2.distanceTransformWithLabels(
        (~known).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    places = np.zeros(labels.max() + 1, np.int64)
    places[labels[known]] = np.flatnonzero(known)
    return places[labels]


def _nearest_known(depth: np.ndarray) -> np.ndarray:
    return depth.reshape(-1)[_nearest(np.isfinite(depth))]
