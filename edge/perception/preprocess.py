"""From a camera picture to the image tower's input, exactly as in training."""

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
    scale = 1.0 / (255.0 * np.asarray(image.std, np.float32))
    offset = np.asarray(image.mean, np.float32) / np.asarray(image.std, np.float32)
    return np.ascontiguousarray((rgb * scale - offset).transpose(2, 0, 1)[None], np.float32)
