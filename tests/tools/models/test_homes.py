import numpy as np
import pytest

from tools.models.homes import fit_relevance, pictures, scaled_logistic


def test_pictures_come_from_every_home():
    found = pictures(range(100, 102), 3)
    assert [rgb.dtype == np.uint8 and rgb.shape == (240, 320, 3) for rgb in found] == [True] * 3


@pytest.mark.parametrize(("middle", "spread"), [(0.25, 0.1), (0.03, 0.002), (-0.1, 0.5)])
def test_a_calibration_that_is_known_is_found(middle, spread):
    rng = np.random.default_rng(0)
    truths = rng.random(4000) < 0.5
    cosines = rng.normal(middle + spread * truths, spread)  # log odds rise by (2 x - 2 middle - spread) / 2 spread
    found = scaled_logistic(cosines, truths)
    assert found["slope"] == pytest.approx(1 / spread, rel=0.1)
    assert found["offset"] == pytest.approx(-(middle + spread / 2) / spread, rel=0.15, abs=0.1)


def test_cosines_that_say_nothing_give_one_half():
    rng = np.random.default_rng(0)
    cosines = rng.normal(size=1000)
    assert scaled_logistic(cosines, cosines < rng.normal(size=1000)) == {"slope": 0.0, "offset": 0.0}


def test_the_shipped_encoders_cosines_rise_with_what_is_shown():
    from edge.perception.encoder import Encoder

    assert fit_relevance(Encoder.load(), range(106, 107), 10)["slope"] > 1
