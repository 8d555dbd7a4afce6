"""The wiring, when a host straightens the graph of a tour."""

import numpy as np
import pytest

from edge.link import requests
from edge.link.alive import declare_alive
from edge.link.requests import RequestError
from tests.edge.node_rig import missions


def carry_ahead(session, robot):
    """What a host makes of the graph: everything is 5 m further."""
    return np.zeros((1, 3)), np.array([[5.0, 0.0, 0.0]])


def refuse(session, robot):
    raise RequestError("the graph is in several pieces")


def break_down(session, robot):
    raise ZeroDivisionError("a fault of ours")


@pytest.mark.parametrize(("answer", "ahead"), [(carry_ahead, 5.0), (refuse, 0.0), (break_down, 0.0)])
def test_with_a_host_a_mapped_graph_is_straightened_and_the_path_goes_along(rig, sessions, monkeypatch, answer, ahead):
    asked = []
    monkeypatch.setattr("edge.node.straighten", lambda *given: asked.append(given[1]) or answer(*given))
    host = declare_alive(sessions[1], "host/alive/test")
    robot = rig(missions(map_steps=30))
    robot.until(lambda: robot.status().state == "idle")
    assert asked == [robot.robot] and robot.status().outcome == "mapped" and not robot.status().problem
    path = robot.ask("map", requests.Map(), requests.MapReply).path.numpy()
    assert ahead <= path[0, 0] < ahead + 3
    host.undeclare()


def test_without_a_host_the_graph_stays_as_it_is(rig, monkeypatch):
    asked = []
    monkeypatch.setattr("edge.node.straighten", lambda *given: asked.append(given) or carry_ahead(*given))
    robot = rig(missions())
    robot.until(lambda: robot.status().state == "idle")
    assert robot.status().outcome == "mapped" and not asked


def test_who_is_never_to_ask_a_host_does_not_ask_it_for_this(rig, sessions, monkeypatch):
    asked = []
    monkeypatch.setattr("edge.node.straighten", lambda *given: asked.append(given) or carry_ahead(*given))
    host = declare_alive(sessions[1], "host/alive/test")
    robot = rig(missions(map_steps=30))
    robot.robot.encoder.mode = "never"
    robot.until(lambda: robot.status().host_alive and robot.status().state == "idle")
    assert robot.status().outcome == "mapped" and not asked
    host.undeclare()
