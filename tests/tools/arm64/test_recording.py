"""What was observed, written and read."""

import numpy as np
import pytest

from edge.observation import STOP
from firmware_sim.house import House
from firmware_sim.world import World
from tests.edge.missions.conftest import PLAN
from tools.arm64.recording import read, write


@pytest.fixture(scope="module")
def lived():
    world = World(House.from_dict(PLAN), 0)
    return [world.step(None), world.step(STOP, look=False), world.step(STOP)]


def test_all_of_it_comes_back(lived, tmp_path):
    write(tmp_path / "mission.npz", lived)
    for seen, again in zip(lived, read(tmp_path / "mission.npz"), strict=True):
        assert again.stamp == seen.stamp and (again.odom == seen.odom).all() and (again.twist == seen.twist).all()
        assert again.bumper is seen.bumper and (again.frame is None) is (seen.frame is None)
        assert (again.scan.ranges == seen.scan.ranges).all() and again.scan.angle_increment == seen.scan.angle_increment
        if seen.frame is not None:
            assert np.abs(again.frame.depth - np.nan_to_num(seen.frame.depth)).max() <= 0.0006
            assert np.abs(again.frame.rgb.astype(int) - seen.frame.rgb).mean() < 5
            assert again.frame.rgb.flags.c_contiguous and again.frame.depth.dtype == np.float32


def test_what_is_written_again_is_the_same(lived, tmp_path):
    write(tmp_path / "one.npz", lived)
    first, again = read(tmp_path / "one.npz"), read(tmp_path / "one.npz")
    assert all((a.frame is None) or (a.frame.rgb == b.frame.rgb).all() for a, b in zip(first, again))
