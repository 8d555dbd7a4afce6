"""The wiring: requests, missions, answers."""

import threading

import numpy as np
import pytest

from edge.link import requests
from edge.link.alive import declare_alive
from edge.link.exchange import NoAnswer
from edge.link.requests import RequestError
from edge.node import Missions, main
from edge.observation import STOP, Twist
from tests.edge.node_rig import Drive, found, mapped, missions
from tests.edge.test_node_straightening import carry_ahead


def test_it_maps_then_finds_and_tells(rig):
    rig = rig(missions())
    rig.until(lambda: rig.status().state == "idle")
    status = rig.status()
    assert status.mapped and status.outcome == "mapped" and status.problem == ""
    assert status.area > 1.0 and status.memory > 10 and status.step_time > 0
    assert Twist(0.2, 0.1) in rig.commands
    assert rig.robot.memory.load_map() is not None
    reply = rig.ask("find", requests.Find("cup"), requests.FindReply)
    assert (reply.status, reply.object, reply.position, reply.confidence) == ("found", "cup", (1.0, 2.0), 0.7)
    assert reply.score == 0.9
    assert reply.box == (1.0, 2.0, 3.0, 4.0) and reply.jpeg[:2] == b"\xff\xd8"
    assert reply.hypotheses[0].members == [(1.1, 0.0, 0.6), (1.0, 0.0, 0.5)]
    (replan,) = reply.replans
    assert replan.probability.numpy().tolist() == [[0, 255], [26, 51]]
    assert (replan.origin, replan.resolution, replan.pose) == ((-1.0, 0.5), 0.05, (1.0, 0.0, 0.0))
    assert rig.status().outcome == "found"


def test_the_mission_gets_whole_observations_at_the_control_rate(rig):
    rig = rig(missions(map_steps=20))
    rig.until(lambda: rig.status().state == "idle")
    seen = rig.robot.observations
    steps = np.diff([observation.stamp for observation in seen])
    assert (steps > 0.075).all() and np.median(steps) < 0.25
    assert sum(observation.scan is not None for observation in seen) > len(seen) * 0.6
    assert sum(observation.frame is not None for observation in seen) > len(seen) * 0.6
    assert (rig.robot.camera.width, rig.robot.camera.height) == (32, 24)  # the announced camera


def test_map_and_graph(rig):
    rig = rig(missions(), mapped=True)
    rig.until(lambda: rig.status().stamp > 0.5)
    rig.robot.memory.add(0.0, (1, 2, 3), np.eye(3), np.eye(4)[:2], [0.0, 0.1])
    reply = rig.ask("map", requests.Map(), requests.MapReply)
    assert set(np.unique(reply.cells.numpy())) == {-1, 0, 100}
    assert reply.path.numpy().shape[1] == 2 and reply.resolution == 0.05
    graph = rig.ask("graph", requests.Graph(vectors_from=0), requests.GraphReply)
    np.testing.assert_allclose(graph.poses.numpy(), [[1, 2, 3]])
    assert graph.vectors.data.numpy().shape == (2, 4) and graph.vectors.owners.numpy().tolist() == [0, 0]
    assert rig.ask("graph", requests.Graph(), requests.GraphReply).vectors is None
    assert len(rig.ask("graph", requests.Graph(vectors_from=1), requests.GraphReply).vectors.owners.numpy()) == 0


def test_one_thing_at_a_time_and_cancel(rig):
    rig = rig(missions(find_steps=10**6), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    answer = []
    asking = threading.Thread(target=lambda: answer.append(rig.ask("find", requests.Find("cup"), requests.FindReply)))
    asking.start()
    rig.until(lambda: rig.status().state == "finding")
    with pytest.raises(RequestError, match="looking for cup.*cancel"):
        rig.ask("find", requests.Find("sofa"), requests.FindReply)
    assert rig.ask("cancel", requests.Cancel(), requests.CancelReply).cancelled
    asking.join(10)
    assert answer[0].status == "cancelled" and answer[0].duration >= 0
    assert not rig.ask("cancel", requests.Cancel(), requests.CancelReply).cancelled
    rig.until(lambda: rig.commands[-1:] == [STOP])


def test_a_known_home_is_toured_again_on_request(rig, sessions, monkeypatch):
    straightened = []
    monkeypatch.setattr("edge.node.straighten", lambda *given: straightened.append(given) or carry_ahead(*given))
    host = declare_alive(sessions[1], "host/alive/test")
    rig = rig(missions(), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    reply = rig.ask("tour", requests.Tour(), requests.TourReply)
    assert (reply.status, reply.duration, reply.distance, reply.nodes) == ("complete", 9.0, 4.0, 0)
    rig.until(lambda: rig.status().state == "idle")
    assert rig.status().outcome == "mapped" and len(straightened) == 1
    host.undeclare()


def test_in_an_unknown_home_it_waits_if_told_to_and_explores_when_asked(rig):
    asked = []

    def find(robot, request):
        asked.append(request)
        return Drive(robot, 3, found(robot))

    rig = rig(missions(find=find), wait=True)
    rig.until(lambda: rig.status().stamp > 0)
    assert rig.status().state == "idle" and not rig.status().mapped
    assert rig.ask("find", requests.Find("cup", explore=True), requests.FindReply).status == "found"
    assert asked == [requests.Find("cup", explore=True)] and not rig.status().mapped


def test_a_tour_that_is_cut_short_or_cancelled_leaves_the_home_known(rig):
    ends = [mapped(complete=False)]
    tours = Missions(lambda robot: Drive(robot, 5 if ends else 10**6, ends.pop() if ends else None), None)
    rig = rig(tours, mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    assert rig.ask("tour", requests.Tour(), requests.TourReply).status == "timeout"
    rig.until(lambda: rig.status().state == "idle")
    assert rig.status().mapped
    answer = []
    asking = threading.Thread(target=lambda: answer.append(rig.ask("tour", requests.Tour(), requests.TourReply)))
    asking.start()
    rig.until(lambda: rig.status().state == "mapping")
    with pytest.raises(RequestError, match="mapping its home.*cancel"):
        rig.ask("tour", requests.Tour(), requests.TourReply)
    assert rig.ask("cancel", requests.Cancel(), requests.CancelReply).cancelled
    asking.join(10)
    assert answer[0].status == "cancelled" and answer[0].nodes == 0 and rig.status().mapped


def test_an_object_that_cannot_be_looked_for_is_refused(rig):
    def find(robot, request):
        raise ValueError("no such word")

    rig = rig(missions(find=find), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    with pytest.raises(RequestError, match="no such word") as caught:
        rig.ask("find", requests.Find("xyzzy"), requests.FindReply)
    assert caught.value.field == "object"
    assert rig.status().state == "idle"


@pytest.mark.parametrize(("complete", "outcome"), [(True, "mapped"), (False, "mapped in part: timeout")])
def test_only_a_home_that_was_mapped_to_the_end_is_mapped_when_the_robot_wakes_up_again(rig, complete, outcome):
    rig = rig(Missions(lambda robot: Drive(robot, 3, mapped(complete)), None))
    rig.until(lambda: rig.status().state == "idle")
    assert rig.status().outcome == outcome and rig.robot.memory.mapped == complete


def test_stopping_the_process_stops_the_robot_and_refuses_who_waits(rig):
    rig = rig(missions(find_steps=10**6), mapped=True)
    rig.until(lambda: rig.status().stamp > 0)
    errors = []

    def ask_for_it():
        try:
            rig.ask("find", requests.Find("cup"), requests.FindReply)
        except (RequestError, NoAnswer) as error:
            errors.append(str(error))

    asking = threading.Thread(target=ask_for_it)
    asking.start()
    rig.until(lambda: rig.status().state == "finding")
    rig.close()
    asking.join(10)
    assert "shutting down" in errors[0]
    rig.until(lambda: rig.commands[-1:] == [STOP])


def test_a_wrong_option_is_told(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--threads", "0"])
    assert ended.value.code == 2 and "--threads must be at least 1" in capsys.readouterr().err
