"""A small home that a robot with true eyes has mapped."""

import json

import pytest

from tests.edge.missions.conftest import PLAN
from tools.eval.tour import map_home


@pytest.fixture(scope="package")
def home(tmp_path_factory):
    """File of the home."""
    file = tmp_path_factory.mktemp("homes") / "two-rooms.json"
    file.write_text(json.dumps(PLAN))
    return str(file)


@pytest.fixture(scope="package")
def tour(home):
    return map_home(home, "oracle", 0)
