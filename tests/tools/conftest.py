"""A small furnished home."""

import json

import pytest

from tests.edge.missions.conftest import PLAN


@pytest.fixture(scope="session")
def home(tmp_path_factory):
    """File of the home."""
    file = tmp_path_factory.mktemp("homes") / "two-rooms.json"
    file.write_text(json.dumps(PLAN))
    return str(file)
