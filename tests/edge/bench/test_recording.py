"""What was observed, written and read."""

import numpy as np
import pytest

from edge.bench.recording import Recording, RecordingError, write
from edge.observation import STOP
from firmware_sim.house import House
from firmware_sim.world import World
from tests.edge.missions.conftest import PLAN


@pytest.fixture(scope="module")
def lived():
    world = World(House.from_dict(PLAN), 0)
    return [world.step(None), world.step(STOP, look=False), world.step(STOP)]


@pytest.fixture
def file(lived, tmp_path):
    prompts = {"a bear": np.array([0.6, 0.8], np.float32)}
    write(tmp_path / "home.rec", lived, [(1, "teddy bear"), (2, "couch")], prompts)
    return tmp_path / "home.rec"


def test_all_of_it_comes_back(lived, file):
    recording = Recording(file)
    assert len(recording) == 3
    for seen, again in zip(lived, recording, strict=True):
        assert again.stamp == seen.stamp and (again.odom == seen.odom).all() and (again.twist == seen.twist).all()
        assert again.bumper is seen.bumper and (again.frame is None) is (seen.frame is None)
        assert (again.scan.ranges == seen.scan.ranges).all() and again.scan.angle_increment == seen.scan.angle_increment
        if seen.frame is not None:
            assert np.abs(again.frame.depth - np.nan_to_num(seen.frame.depth)).max() <= 0.0006
            assert np.abs(again.frame.rgb.astype(int) - seen.frame.rgb).mean() < 5
            assert again.frame.rgb.flags.c_contiguous and again.frame.depth.dtype == np.float32


def test_what_was_asked_and_answered_comes_back(file):
    recording = Recording(file)
    assert recording.questions == [(1, "teddy bear"), (2, "couch")]
    assert list(recording.prompts) == ["a bear"] and recording.prompts["a bear"] == pytest.approx([0.6, 0.8])


def test_it_can_be_read_again_from_the_front(file):
    recording = Recording(file)
    assert [seen.stamp for seen in recording] == [seen.stamp for seen in recording]


def test_one_without_questions(lived, tmp_path):
    write(tmp_path / "tour.rec", lived)
    recording = Recording(tmp_path / "tour.rec")
    assert recording.questions == [] and recording.prompts == {} and len(list(recording)) == 3


def test_a_missing_file_is_told_in_a_sentence(tmp_path):
    with pytest.raises(RecordingError, match="nowhere.rec cannot be read .* make a recording with: vlpg bench record"):
        Recording(tmp_path / "nowhere.rec")


@pytest.mark.parametrize("content", [b"", b"something else", b"\x93NUMPY"])
def test_another_file_is_told_in_a_sentence(tmp_path, content):
    (tmp_path / "other").write_bytes(content)
    with pytest.raises(RecordingError, match="no whole recording"):
        Recording(tmp_path / "other")


def test_one_that_was_cut_off_is_told_when_it_ends(file):
    file.write_bytes(file.read_bytes()[:-1000])
    with pytest.raises(RecordingError, match="no whole recording"):
        list(Recording(file))


def test_another_array_file_is_no_recording(tmp_path):
    np.save(tmp_path / "array.npy", np.arange(3))
    with pytest.raises(RecordingError, match="no whole recording"):
        Recording(tmp_path / "array.npy")
