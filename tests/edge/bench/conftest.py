"""A few observations of a small home, in a file."""

import numpy as np
import pytest

from edge.bench.recording import write
from edge.observation import Twist
from edge.perception.prompts import contrast
from firmware_sim.house import House
from firmware_sim.world import World
from tests.edge.missions.conftest import PLAN


@pytest.fixture(scope="package")
def recording(tmp_path_factory):
    world = World(House.from_dict(PLAN), 0)
    observations = [world.step(None), *(world.step(Twist(0.0, 0.5)) for _ in range(5))]
    file = tmp_path_factory.mktemp("recording") / "home.rec"
    vectors = np.eye(2, 384, dtype=np.float32)
    write(file, observations, [(4, "couch")], dict(zip(contrast("couch"), vectors)))
    return file
