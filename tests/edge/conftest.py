"""A node that runs until the end of the test."""

import pytest

from tests.edge.node_rig import Rig


@pytest.fixture
def rig(sessions):
    rigs = []

    def start(missions, mapped=False, wait=False):
        rigs.append(Rig(sessions, missions, mapped, wait))
        return rigs[-1]

    yield start
    for started in rigs:
        started.close()
