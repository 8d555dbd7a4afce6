"""Pictures as JPEG."""

import cv2
import numpy as np


def jpeg(rgb: np.ndarray, quality: int) -> bytes:
    """The bytes of RGB ``(H, W, 3)`` uint8 at a ``quality`` from 0 to 100."""
    return cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
