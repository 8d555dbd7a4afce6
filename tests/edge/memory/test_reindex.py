import numpy as np
import pytest

from edge.memory.database import EncoderMismatch, StoreError
from edge.memory.reindex import Reindexed, reindex
from edge.memory.store import Vlpg


def embed(jpeg, hfov):
    """The new encoder: the picture's first byte says along which of 8 axes it lies."""
    return np.eye(8)[[jpeg[0], jpeg[0]]], [0.0, 0.5]


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "home.vlpg"
    with Vlpg.open(path, "old", "aa", 4) as store:
        for n in range(3):
            picture = None if n == 1 else bytes([n])
            store.add(n, (n, 0, 0), np.eye(3), np.eye(4)[[n]], [0.0], keyframe=picture)
        store.save_map(b"map")
    return path


def test_the_graph_stays_and_the_pictures_are_looked_at_again(path):
    with pytest.raises(EncoderMismatch):
        Vlpg.open(path, "new", "bb", 8)
    assert reindex(path, "new", "bb", 8, embed) == Reindexed(embedded=2, withdrawn=1)
    with Vlpg.open(path, "new", "bb", 8) as store:
        assert store.ids.tolist() == [0, 2] and store.load_map() == b"map"
        assert len(store.edges().i) == 2 and store.poses([1])[0].tolist() == [1, 0, 0]
        hits = store.search(np.eye(8)[2], 2)
        assert hits.ids.tolist() == [2, 2] and sorted(hits.bearings.tolist()) == [0.0, 0.5]
        assert store.add(9.0, (9, 0, 0), np.eye(3), np.eye(8)[[5]], [0.0]) == 3
    with Vlpg.open(path.with_name("home.vlpg.before-reindex"), "old", "aa", 4) as store:
        assert len(store) == 3


def test_whatever_goes_wrong_the_store_is_as_it_was(path):
    def breaks(jpeg, hfov):
        raise ValueError("the picture is damaged")

    with pytest.raises(ValueError, match="damaged"):
        reindex(path, "new", "bb", 8, breaks)
    with Vlpg.open(path, "old", "aa", 4) as store:
        assert len(store) == 3
    assert sorted(file.name for file in path.parent.iterdir()) == ["home.vlpg", "home.vlpg.lock"]


def test_there_is_a_store_at_any_time(path, monkeypatch):
    def power_cut(*_):
        raise OSError("no power")

    monkeypatch.setattr("edge.memory.reindex.os.replace", power_cut)
    with pytest.raises(StoreError, match="cannot be replaced .no power."):
        reindex(path, "new", "bb", 8, embed)
    with Vlpg.open(path, "old", "aa", 4) as store:
        assert len(store) == 3


def test_a_store_without_pictures_must_be_mapped_anew(tmp_path):
    path = tmp_path / "home.vlpg"
    with Vlpg.open(path, "old", "aa", 4) as store:
        store.add(0.0, (0, 0, 0), np.eye(3), np.eye(4)[[0]], [0.0])
    with pytest.raises(StoreError, match="map the home anew"):
        reindex(path, "new", "bb", 8, embed)


def test_what_is_no_store_is_left_alone(tmp_path):
    path = tmp_path / "diary"
    path.write_bytes(b"dear diary" * 500)
    with pytest.raises(StoreError, match="left as it is"):
        reindex(path, "new", "bb", 8, embed)
    assert path.read_bytes() == b"dear diary" * 500
    with pytest.raises(StoreError, match="no store"):
        reindex(tmp_path / "nowhere", "new", "bb", 8, embed)


def test_a_store_that_a_robot_uses_is_left_alone(path):
    with Vlpg.open(path, "old", "aa", 4) as used:
        used.add(7.0, (7, 0, 0), np.eye(3), np.eye(4)[[0]], [0.0], keyframe=b"\x03")
        with pytest.raises(StoreError, match="in use; stop the robot that uses it"):
            reindex(path, "new", "bb", 8, embed)
        used.save_map(b"newer")
    assert sorted(file.name for file in path.parent.iterdir()) == ["home.vlpg", "home.vlpg.lock"]
    assert reindex(path, "new", "bb", 8, embed).embedded == 3


@pytest.mark.parametrize("mapped", [True, False])
def test_what_is_known_of_the_home_and_the_camera_stays(path, mapped):
    with Vlpg.open(path, "old", "aa", 4) as store:
        store.note_camera(1.2)
        if mapped:
            store.mark_mapped()
    angles = []
    reindex(path, "new", "bb", 8, lambda jpeg, hfov: angles.append(hfov) or embed(jpeg, hfov))
    with Vlpg.open(path, "new", "bb", 8) as store:
        assert store.mapped == mapped and angles == [1.2, 1.2]


def test_no_robot_opens_the_store_while_it_is_moved(path):
    def meanwhile(jpeg, hfov):
        with pytest.raises(StoreError, match="in use; stop the robot"):
            Vlpg.open(path, "old", "aa", 4)
        return embed(jpeg, hfov)

    assert reindex(path, "new", "bb", 8, meanwhile).embedded == 2


def test_the_lock_is_the_stores_owners(path, monkeypatch):
    owned = []
    monkeypatch.setattr("edge.memory.reindex.os.fchown", lambda file, *owner: owned.append(owner))
    path.with_name("home.vlpg.lock").unlink()
    reindex(path, "new", "bb", 8, embed)
    assert owned == [(path.stat().st_uid, path.stat().st_gid)]


def test_a_store_none_of_whose_pictures_can_be_read_is_left_as_it_is(path):
    with pytest.raises(StoreError, match="none of the pictures"):
        reindex(path, "new", "bb", 8, lambda jpeg, hfov: None)
    with Vlpg.open(path, "old", "aa", 4) as store:
        assert len(store) == 3


def test_a_picture_that_cannot_be_read_costs_its_node_only(path):
    result = reindex(path, "new", "bb", 8, lambda jpeg, hfov: None if jpeg[0] == 0 else embed(jpeg, hfov))
    assert result == Reindexed(embedded=1, withdrawn=2)
    with Vlpg.open(path, "new", "bb", 8) as store:
        assert store.ids.tolist() == [2]
