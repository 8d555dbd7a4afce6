import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from edge.perception.detection import Detector, DetectorConfig, salient_region
from edge.perception.encoder import View
from edge.perception.prompts import Target

SIZE = (320, 240)


class FixedEncoder:
    """Stands in for the encoder: the saliency and scale are given, the arithmetic of the detector is what is tested."""

    logit_scale = 10.0

    def __init__(self, saliency):
        self._saliency = saliency

    def saliency(self, view, direction):
        return self._saliency


def view(*cosines):
    vectors = np.array([[c, np.sqrt(1 - c * c)] for c in cosines], np.float32)
    return View(vectors, np.zeros(len(cosines)), (np.zeros((1, 7, 9), np.float32),))


TARGET = Target("lamp", np.array([1.0, 0.0], np.float32), np.zeros(2, np.float32))


def test_the_box_surrounds_the_salient_cells():
    saliency = np.zeros((6, 8), np.float32)
    saliency[2:4, 5:7] = 1.0  # cells of 40 px: x 200-280, y 80-160
    box, mask = salient_region(saliency, SIZE, 0.5)
    assert box == pytest.approx((200, 80, 280, 160), abs=8)
    assert mask.shape == (box[3] - box[1], box[2] - box[0]) and mask.mean() > 0.8


def test_the_stronger_component_wins_over_the_longer_one():
    saliency = np.zeros((6, 8), np.float32)
    saliency[0, :] = 0.55
    saliency[3:6, 2:4] = 1.0
    (x0, y0, x1, y1), mask = salient_region(saliency, SIZE, 0.5)
    assert y0 > 80 and 60 < x0 < x1 < 180 and mask.any(0).all() and mask.any(1).all()


@given(hnp.arrays(np.float32, (7, 9), elements=st.floats(0, 10, width=32)))
def test_a_box_lies_in_the_picture_and_holds_something(saliency):
    region = salient_region(saliency, SIZE, 0.5)
    if saliency.max() <= 0:
        assert region is None
    elif region is not None:
        (x0, y0, x1, y1), mask = region
        assert mask.any() and mask.shape == (y1 - y0, x1 - x0)
        assert 0 <= x0 < x1 <= 320 and 0 <= y0 < y1 <= 240


def test_the_score_is_the_two_prompt_softmax_of_the_best_region():
    detector = Detector(FixedEncoder(np.ones((7, 9))))
    cosines = (-0.5, 0.1, 0.3, -0.2)
    logits = 10 * np.array([0.3, 0.0])
    assert detector.score(view(*cosines), TARGET) == pytest.approx(np.exp(logits[0]) / np.exp(logits).sum(), rel=1e-5)


def test_no_detection_below_the_score():
    detector = Detector(FixedEncoder(np.ones((7, 9))), DetectorConfig(min_score=0.9))
    assert detector.detect(view(0.1), TARGET, SIZE) is None
    assert detector.detect(view(0.9), TARGET, SIZE).score > 0.9


@pytest.mark.parametrize("saliency", [np.zeros((7, 9)), np.full((7, 9), np.nan)])
def test_no_detection_without_saliency(saliency):
    assert Detector(FixedEncoder(saliency)).detect(view(0.9), TARGET, SIZE) is None
