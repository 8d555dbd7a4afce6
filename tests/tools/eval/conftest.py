"""A small home that a robot with true eyes has mapped."""

import pytest

from tools.eval.tour import map_home


@pytest.fixture(scope="package")
def tour(home):
    return map_home(home, "oracle", 0)
