"""The occupancy grid as bytes: a checked header, then the layers, compressed."""

import struct
import zlib

import numpy as np

MAGIC = b"VLPGMAP"
VERSION = 2
LAYERS = 3
_HEADER = struct.Struct("<7sBdiiIIIII")  # magic, version, resolution, corner row col, layers, rows, cols, length, crc32
_MAX_CELLS = 64_000_000  # a damaged header must not ask for gigabytes; 400x400 m at 0.05 m


def pack(resolution: float, corner: np.ndarray, layers: np.ndarray) -> bytes:
    """Bytes of ``layers`` int8 ``(L, H, W)`` whose cell [0, 0] is ``corner`` (row, col) cells from the map's origin."""
    body = zlib.compress(np.ascontiguousarray(layers, np.int8).tobytes(), level=6)
    fields = (MAGIC, VERSION, resolution, int(corner[0]), int(corner[1]), *layers.shape, len(body))
    unsigned = _HEADER.pack(*fields, 0)
    return _HEADER.pack(*fields, zlib.crc32(unsigned + body)) + body


def unpack(data: bytes) -> tuple[float, np.ndarray, np.ndarray]:
    """Resolution [m], corner (row, col) and layers ``(LAYERS, H, W)`` int8 of ``pack``'s bytes.

    Raises ValueError, saying what to do, when the bytes are no map, of another version, cut short or altered.
    """
    if len(data) < _HEADER.size or bytes(data[: len(MAGIC)]) != MAGIC:
        raise ValueError("This is not a saved map, or it is cut short; restore a backup or map the home again.")
    *fields, crc = _HEADER.unpack_from(data)
    _, version, resolution, row, col, count, rows, cols, length = fields
    if version != VERSION:
        raise ValueError(f"The saved map has format {version} but this release reads {VERSION}; map the home again.")
    body = bytes(data[_HEADER.size :])
    if len(body) != length or zlib.crc32(_HEADER.pack(*fields, 0) + body) != crc:
        raise ValueError("The saved map is damaged (checksum differs); restore a backup or map the home again.")
    if count != LAYERS or not 0 < rows * cols <= _MAX_CELLS or not resolution > 0:
        raise ValueError("The saved map has a shape that no map has; restore a backup or map the home again.")
    try:
        cells = np.frombuffer(zlib.decompress(body), np.int8)
        return resolution, np.array([row, col]), cells.reshape(count, rows, cols).copy()
    except (zlib.error, ValueError) as error:
        raise ValueError("The saved map is damaged; restore a backup or map the home again.") from error
