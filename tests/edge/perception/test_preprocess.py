from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edge.perception.preprocess import preprocess
from models.manifest import Image, Manifest, resolve

SPEC = Image("", "", 64, 96, (0.5, 0.4, 0.3), (0.2, 0.3, 0.4), ((0, 1),))


def test_a_picture_of_the_right_size_is_only_normalized():
    rgb = np.random.default_rng(0).integers(0, 256, (64, 96, 3), dtype=np.uint8)
    expected = ((rgb / 255.0 - SPEC.mean) / SPEC.std).transpose(2, 0, 1)[None]
    result = preprocess(rgb, SPEC)
    assert result.dtype == np.float32 and result.flags.c_contiguous
    np.testing.assert_allclose(result, expected, atol=1e-5)


def test_shrinking_is_the_mean_over_areas():
    rgb = np.random.default_rng(1).integers(0, 256, (128, 192, 3), dtype=np.uint8)
    blocks = rgb.reshape(64, 2, 96, 2, 3).mean((1, 3))
    expected = ((blocks / 255.0 - SPEC.mean) / SPEC.std).transpose(2, 0, 1)
    np.testing.assert_allclose(preprocess(rgb, SPEC)[0], expected, atol=0.51 / 255 / 0.2)


@given(st.integers(1, 300), st.integers(1, 300), st.integers(0, 255))
def test_any_size_of_one_colour_stays_that_colour(height, width, value):
    result = preprocess(np.full((height, width, 3), value, np.uint8), SPEC)
    assert result.shape == (1, 3, 64, 96)
    np.testing.assert_allclose(result[0, 0], (value / 255 - 0.5) / 0.2, atol=1e-4)


@pytest.mark.parametrize(
    "picture",
    [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), np.uint8)],
)
def test_what_is_not_a_picture_is_refused(picture):
    with pytest.raises(ValueError, match=r"must be \(H, W, 3\) uint8"):
        preprocess(picture, SPEC)


def test_it_is_what_training_saw():
    """The golden file of `tools.train`: the numbers that the shipped tower was trained and calibrated on."""
    image = Manifest.load(resolve()).image
    with np.load(Path(__file__).parent / "preprocess_golden.npz") as golden:
        pictures = [golden[f"picture{i}"] for i in range(len(golden.files) - 1)]
        seen = golden["seen"]
    assert len({picture.shape for picture in pictures}) == len(pictures) >= 6
    found = np.concatenate([preprocess(rgb, image) for rgb in pictures])[:, :, ::16, ::16]
    # Nothing but the rounding of a resized pixel may differ: other builds of OpenCV add in another order.
    one_level = 1.01 / 255 / np.array(image.std).min()
    assert np.abs(found - seen).max() <= one_level
    assert np.abs(found - seen).mean() < 0.01 * one_level
