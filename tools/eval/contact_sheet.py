"""Contact sheets: many small pictures with what is said of them, as one JPEG that a README can show."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

LIMIT = 400_000  # bytes
GOOD, NEAR, BAD, INK = (0, 130, 50), (190, 110, 0), (170, 30, 30), (40, 40, 40)  # RGB
_PAPER, _MARGIN, _LINE, _SCALE = 255, 6, 14, 0.38  # px, and the size of the letters


@dataclass(frozen=True)
class Tile:
    """RGB ``(H, W, 3)`` uint8 of any size, and lines of text with their colours below it."""

    rgb: np.ndarray
    lines: tuple[tuple[str, tuple[int, int, int]], ...]


def contact_sheet(tiles: list[Tile], columns: int, size: tuple[int, int] = (144, 108)) -> np.ndarray:
    """RGB of all tiles, row by row, each fitted into ``size`` (width, height) px."""
    width, height = size
    deep = height + _LINE * max(len(tile.lines) for tile in tiles) + 4
    rows = -(-len(tiles) // columns)
    shape = (rows * (deep + _MARGIN) + _MARGIN, columns * (width + _MARGIN) + _MARGIN, 3)
    sheet = np.full(shape, _PAPER, np.uint8)
    for i, tile in enumerate(tiles):
        y, x = (k * (side + _MARGIN) + _MARGIN for k, side in zip(divmod(i, columns), (deep, width)))
        small = _fitted(tile.rgb, size)
        top, left = y + (height - small.shape[0]) // 2, x + (width - small.shape[1]) // 2
        sheet[top : top + small.shape[0], left : left + small.shape[1]] = small
        for line, (words, colour) in enumerate(tile.lines):
            place = (x, y + height + _LINE * (line + 1) - 2)
            cv2.putText(sheet, _cut(words, width), place, cv2.FONT_HERSHEY_SIMPLEX, _SCALE, colour, 1, cv2.LINE_AA)
    return sheet


def save(sheet: np.ndarray, path: Path) -> None:
    """Write RGB as the best JPEG that is not larger than ``LIMIT``. Raises ValueError if none is."""
    for quality in range(90, 20, -5):
        data = cv2.imencode(".jpg", cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        if len(data) <= LIMIT:
            Path(path).write_bytes(data.tobytes())
            return
    raise ValueError(f"{path} would be larger than {LIMIT // 1000} kB: put fewer or smaller pictures on the sheet.")


def _fitted(rgb: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    scale = min(size[0] / rgb.shape[1], size[1] / rgb.shape[0])
    shape = max(1, round(rgb.shape[1] * scale)), max(1, round(rgb.shape[0] * scale))
    return cv2.resize(rgb, shape, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)


def _cut(words: str, width: int) -> str:
    """As much as fits in ``width`` px; Hershey's letters are ASCII."""
    words = words.encode("ascii", "replace").decode()
    whole = words
    while words and cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, _SCALE, 1)[0][0] > width:
        words = words[:-1]
    return words if words == whole else words[:-1] + "."
