"""The geometry behind the motions."""

import numpy as np
import pytest

from edge.missions.motion import length

PATH = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.55]])


def test_length_is_that_of_all_stretches():
    assert length(PATH) == pytest.approx(1.55)
