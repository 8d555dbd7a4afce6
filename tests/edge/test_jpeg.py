import cv2
import numpy as np

from edge.jpeg import jpeg


def test_the_colours_are_those_of_the_picture():
    rgb = np.zeros((16, 16, 3), np.uint8)
    rgb[...] = (200, 100, 30)
    back = cv2.imdecode(np.frombuffer(jpeg(rgb, 90), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert np.abs(back.astype(int) - rgb).max() < 4
    noise = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    assert len(jpeg(noise, 30)) < len(jpeg(noise, 90))
