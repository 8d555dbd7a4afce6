"""The wiring, when the base, the disk or a mission fails."""

import sqlite3
import threading
from dataclasses import replace

import pytest

from edge.camera import CameraModel
from edge.link import requests
from edge.link.requests import RequestError
from edge.memory.store import Vlpg
from edge.observation import STOP, Twist
from tests.edge.node_rig import Drive, found, missions


def test_a_silent_base_is_told_to_stop_and_so_are_people(rig):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: Twist(0.2, 0.1) in rig.commands)
    rig.silence()
    rig.until(lambda: rig.commands[-1:] == [STOP])
    rig.until(lambda: "no odometry" in rig.status().problem)
    assert rig.status().state == "mapping"
    rig._publishing.set()
    rig.until(lambda: rig.commands[-1] == Twist(0.2, 0.1))


def test_while_a_sensor_is_silent_the_mission_waits(rig):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: Twist(0.2, 0.1) in rig.commands)
    rig.lidar = False
    rig.until(lambda: "lidar sends nothing" in rig.status().problem)
    rig.until(lambda: rig.commands[-1:] == [STOP])
    assert rig.status().state == "mapping"
    rig.lidar = True
    rig.until(lambda: rig.commands[-1] == Twist(0.2, 0.1))
    assert rig.status().problem == ""


def test_after_the_base_started_anew_the_growing_map_is_saved_as_before(rig, monkeypatch):
    rig = rig(missions(map_steps=10**6))
    rig.node.config = replace(rig.node.config, save_every=1.0)
    rig.time = 10_000.0
    rig.until(lambda: rig.status().stamp > 10_001)
    rig.time = 0.0
    rig.until(lambda: rig.status().state == "idle" and rig.status().stamp < 100)
    asking = threading.Thread(
        target=lambda: pytest.raises(RequestError, rig.ask, "tour", requests.Tour(), requests.TourReply)
    )
    asking.start()
    rig.until(lambda: rig.status().state == "mapping")
    saved = []
    monkeypatch.setattr(rig.robot.memory, "save_map", saved.append)
    rig.until(lambda: len(saved) > 2)
    rig.stop.set()
    asking.join(10)


def test_a_mission_that_breaks_stops_the_robot_and_keeps_the_map_and_the_next_may_do_better(rig, caplog):
    def find(robot, request):
        return Drive(robot, 3, found(robot), breaks=request.object == "zero")

    rig = rig(missions(breaks=True, find=find))
    rig.until(lambda: rig.status().state == "idle")
    rig.until(lambda: rig.commands and rig.commands[-1] == STOP)
    assert "divided by zero" in rig.status().problem and not rig.status().mapped
    assert rig.robot.memory.load_map() is not None
    with pytest.raises(RequestError, match="divided by zero"):
        rig.ask("find", requests.Find("zero"), requests.FindReply)
    assert rig.ask("find", requests.Find("cup"), requests.FindReply).status == "found"
    assert rig.status().problem == ""


def test_a_base_that_starts_anew_ends_the_mission_and_the_robot_seeks_its_place(rig):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: rig.time > 3 and rig.status().stamp > 2)
    rig.time = 0.0
    rig.until(lambda: rig.status().state == "idle")
    assert "restarted" in rig.status().problem and rig.robot.localizer.lost
    rig.until(lambda: rig.status().stamp < 2)


def test_pictures_of_an_unknown_camera_are_not_looked_at(rig):
    rig = rig(missions(), mapped=True)
    rig.until(lambda: any(seen.frame is not None for seen in rig.robot.observations))
    rig.picture = (30, 40)
    rig.until(lambda: "camera_info for pictures of 40 x 30" in rig.status().problem)
    count = len(rig.robot.observations)
    rig.until(lambda: len(rig.robot.observations) > count + 10)
    assert all(seen.frame is None for seen in rig.robot.observations[count + 2 :])
    rig.camera = CameraModel(width=40, height=30)
    rig.until(lambda: rig.robot.observations[-1].frame is not None)
    assert rig.robot.camera.width == 40 and rig.status().problem == ""


def test_a_full_disk_is_told_and_survived(rig, monkeypatch, caplog):
    rig = rig(missions(map_steps=10**6))
    rig.until(lambda: rig.status().state == "mapping")

    def full(data):
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr(rig.robot.memory, "save_map", full)
    rig.ask("cancel", requests.Cancel(), requests.CancelReply)
    assert "disk is full" in rig.status().problem and rig.status().state == "idle"


def test_views_that_are_not_remembered_are_told(rig):
    rig = rig(missions(), mapped=True)
    rig.robot.forgets = "views are not remembered"
    rig.until(lambda: rig.status().problem == "views are not remembered")


def test_what_an_idle_robot_sees_is_committed_now_and_then(rig, monkeypatch):
    flushed = []
    monkeypatch.setattr(Vlpg, "flush", lambda memory: flushed.append(memory))
    rig = rig(missions(), mapped=True)
    rig.node.config = replace(rig.node.config, save_every=0.5)
    rig.until(lambda: len(flushed) > 2)
    assert rig.robot.memory.load_map() is None  # which has not changed


def test_what_a_full_disk_did_not_take_is_saved_when_it_has_room_again(rig, monkeypatch, caplog):
    full = True
    keep_map = Vlpg._keep_map

    def limited(memory, data):
        if full:
            raise sqlite3.OperationalError("database or disk is full")
        keep_map(memory, data)

    monkeypatch.setattr(Vlpg, "_keep_map", limited)
    rig = rig(missions(map_steps=30))
    rig.node.config = replace(rig.node.config, save_every=0.5)
    rig.until(lambda: rig.status().outcome == "mapped" and "disk is full" in rig.status().problem)
    later = rig.time + 2
    rig.until(lambda: rig.time > later)  # other savings, of nothing, do not hide it
    assert "disk is full" in rig.status().problem
    full = False
    rig.until(lambda: not rig.status().problem)
    memory = rig.robot.memory
    assert memory.mapped and memory.load_map() and memory._meta("hfov") == repr(rig.robot.camera.hfov)
