"""From a camera picture to the image tower's input, exactly as in training."""

from functools import cache

import cv2
import numpy as np

from models.manifest import Image


def preprocess(rgb: np.ndarray, image: Image) -> np.ndarray:
    """RGB ``(H, W, 3)`` uint8 of any size to ``(1, 3, height, width)`` float32, stretched to the tower's input size.

    Shrinking averages over areas and enlarging interpolates, so that small objects do not alias away.

    Raises:
        ValueError: not a non-empty ``(H, W, 3)`` uint8 array.
    """
    rgb = np.asarray(rgb)
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8 or rgb.size == 0:
        raise ValueError(f"A picture must be (H, W, 3) uint8, not {rgb.shape} {rgb.dtype}.")
    if rgb.shape[:2] != (image.height, image.width):
        shrinks = rgb.shape[0] >= image.height and rgb.shape[1] >= image.width
        method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        rgb = cv2.resize(rgb, (image.width, image.height), interpolation=method)
    planes = np.empty((1, 3, image.height, image.width), np.float32)
    for plane, channel, levels in zip(planes[0], cv2.split(rgb), _normalized(image.mean, image.std)):
        cv2.LUT(channel, levels, dst=plane)
    return planes


@cache
def _normalized(mean: tuple[float, ...], std: tuple[float, ...]) -> np.ndarray:
    """What each of the 256 levels becomes in each channel, ``(3, 256)`` float32: looked up, it need not be computed."""
    mean, std = np.array(mean, np.float32)[:, None], np.array(std, np.float32)[:, None]
    return np.arange(256, dtype=np.uint8) * (1.0 / (255.0 * std)) - mean / std
