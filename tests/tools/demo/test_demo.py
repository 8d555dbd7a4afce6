"""The story of a demo with a robot that is made up; tests/tools/demo/test_three_processes.py has a real one."""

import io
import json
import time
from itertools import count
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from rich.console import Console

from edge.camera import CameraModel
from edge.link.exchange import NoAnswer
from edge.link.requests import Array, FindReply, GraphReply, Hypothesis, MapReply, Replan, RequestError
from edge.pose import between
from firmware_sim.house import House
from tools.demo import demo as demo_module
from tools.demo.demo import Demo, DemoConfig, DemoError, run_demo
from tools.demo.processes import ProcessDied, Supervisor
from tools.demo.progress import Display
from tools.demo.recorder import Recorder

JPEG = cv2.imencode(".jpg", np.zeros((240, 320, 3), np.uint8))[1].tobytes()


class MadeUpRobot:
    """Maps for three questions, then claims to have found whatever it is asked for."""

    def __init__(self, house):
        self.house = house
        self.asked, self.cancelled, self.answer = [], 0, "found"
        self.states = ["mapping", "mapping", "mapping", "idle"]
        self.problem, self.stamps = "", count(20.0, 10.0)  # s; the base's clock has run before

    def status(self):
        state = self.states.pop(0) if len(self.states) > 1 else self.states[0]
        home = {"viewed": 40.0 if state == "idle" else 10.0, "area": 40.0, "nodes": 30, "mapped": not self.problem}
        return SimpleNamespace(state=state, **home, distance=20.0, stamp=next(self.stamps), problem=self.problem)

    def cancel(self):
        self.cancelled += 1
        self.states = ["idle"]
        self.answer = "cancelled"

    def find(self, words, search_unknown=False):
        self.asked.append((words, search_unknown))
        if self.answer == "slow":
            while self.answer == "slow":
                time.sleep(0.01)
        pose = (1.0, 0.0, 0.0)
        if self.answer != "found":
            return FindReply(self.answer, words, pose, 5.0, 2.0, [], jpeg=JPEG)
        hypotheses = [Hypothesis(pose, 0.9, [pose])]
        replan = Replan(Array.of(np.full((4, 6), 25, np.uint8)), (0.0, 0.0), 0.05, pose)
        seen = (2.0, 0.0), 0.0, 1.0, 0.9, (1, 2, 30, 40), JPEG
        return FindReply("found", words, pose, 5.0, 2.0, hypotheses, *seen, confidence=0.6, replans=[replan])

    def map(self):
        return MapReply(Array.of(np.zeros((20, 30), np.int8)), (0.0, 0.0), 0.05, Array.of(np.zeros((0, 2), np.float32)))

    def graph(self):
        poses = np.zeros((2, 3))
        return GraphReply(Array.of(np.arange(2)), Array.of(poses), Array.of(np.zeros((0, 2), int)), "", "", "")


class MadeUpTruth:
    """A robot that stands 1 m west of the teddy bear and looks at it, whatever it was asked for."""

    def __init__(self, house):
        self.house, self.config = house, SimpleNamespace(camera_model=CameraModel())
        bear = house.objects["teddy-bear-1"]
        self.truth = np.array([bear.x - 1.0, bear.y, 0.0])

    def look(self, object_ids):
        self.looked_at = list(object_ids)

    def visible_fraction(self, object_id):
        return 0.9 if object_id == "teddy-bear-1" else 0.0

    def position(self):
        return self.truth[:2]


@pytest.fixture
def house():
    return House.load("apartment")


@pytest.fixture
def demo(house, tmp_path):
    recorder = Recorder(house, 0, 4.0, "never", tmp_path)
    display = Display(Console(file=io.StringIO(), force_terminal=False))
    demo = Demo(DemoConfig(), recorder, Supervisor(tmp_path), display)
    demo.robot, demo.truth = MadeUpRobot(house), MadeUpTruth(house)
    demo.printed = display.console.file.getvalue
    return demo


def test_mapping_is_waited_for_and_told(demo):
    demo.map_home()
    assert demo.robot.cancelled == 0
    mapping = demo.recorder.finish().mapping
    assert (mapping.complete, mapping.area, mapping.nodes, mapping.duration) == (True, 40.0, 30, 30.0)
    assert "40.0 m² of free floor, 30 nodes" in demo.printed()


def test_mapping_that_takes_too_long_is_broken_off(demo, house, tmp_path):
    demo.config = DemoConfig(time_limit=0.1)
    demo.robot.states = ["mapping"]
    demo.map_home()
    assert demo.robot.cancelled == 1
    assert not demo.recorder.finish().mapping.complete
    assert "broken off" in demo.recorder.notes[0]


def test_a_robot_that_fails_while_mapping_ends_the_demo(demo):
    demo.robot.problem = "it fell over"
    with pytest.raises(RequestError, match="it fell over"):
        demo.map_home()


def test_a_true_claim_is_confirmed_and_kept(demo, house, tmp_path):
    demo.find("teddy bear", 10.0)
    search = demo.recorder.finish().searches[0]
    assert (search.verdict, search.status, search.visible) == ("confirmed", "found", 0.9)
    assert search.picture == "1-teddy-bear.jpg" and search.picture_size == (320, 240)
    assert (tmp_path / search.picture).read_bytes() == JPEG
    # The robot's map begins at the dock.
    assert between(house.start, search.pose) == pytest.approx((1.0, 0.0, 0.0), abs=1e-3)
    assert search.hypotheses[0].pose == pytest.approx(search.pose)
    assert search.confidence == 0.6
    (replan,) = search.replans
    assert replan.pose == pytest.approx(search.pose) and replan.probability.shape == (4, 6)
    assert (tmp_path / replan.probability.picture).is_file()
    assert demo.truth.looked_at == ["teddy-bear-1"]
    assert "found          teddy bear: 5 s, 2.0 m, 0° off, confirmed." in demo.printed()


def test_a_false_claim_is_called_wrong(demo):
    demo.find("wardrobe", 10.0)
    assert demo.recorder.finish().searches[0].verdict == "wrong"


def test_the_best_guesses_are_looked_at_only_if_asked(demo):
    demo.find("desk", 10.0)
    demo.config = DemoConfig(search_unknown=True)
    demo.find("desk", 10.0)
    assert demo.robot.asked == [("desk", False), ("desk", True)]


def test_a_search_that_outlasts_the_demo_is_cancelled(demo):
    demo.robot.answer = "slow"
    demo.find("teddy bear", 0.2)
    search = demo.recorder.finish().searches[0]
    assert (search.status, search.verdict) == ("cancelled", "no claim")
    assert demo.recorder.notes == ["The search for teddy bear was called off after 0 s for lack of time."]


def test_what_there_was_no_time_for_is_told(demo):
    demo.out_of_time(["desk"])
    demo.out_of_time(["desk", "lamp"])
    assert demo.recorder.notes == [
        "Time ran out: desk was not asked for.",
        "Time ran out: desk, lamp were not asked for.",
    ]


def _run(monkeypatch, tmp_path, story, **settings):
    """Exit code and report of a demo whose run is ``story(demo)``."""

    def run(demo):
        demo.robot, demo.truth = MadeUpRobot(demo.recorder.house), MadeUpTruth(demo.recorder.house)
        story(demo)

    monkeypatch.setattr(demo_module.Demo, "run", run)
    code = run_demo(DemoConfig(out=tmp_path, **settings))
    (folder,) = tmp_path.iterdir()
    assert (folder / "report.html").is_file()
    return code, json.loads((folder / "report.json").read_text())


def test_exit_code_of_a_true_claim(monkeypatch, tmp_path):
    code, report = _run(monkeypatch, tmp_path, lambda demo: demo.find("teddy bear", 10.0))
    assert code == 0 and report["searches"][0]["verdict"] == "confirmed"


def test_exit_code_of_a_false_claim(monkeypatch, tmp_path):
    code, report = _run(monkeypatch, tmp_path, lambda demo: demo.find("elephant", 10.0))
    assert code == 1 and report["searches"][0]["verdict"] == "wrong"


@pytest.mark.parametrize("error", [ProcessDied("The sim process ended.\nlast words"), NoAnswer("nobody")])
def test_exit_code_and_report_of_a_process_that_died(monkeypatch, tmp_path, capsys, error):
    def story(demo):
        demo.find("teddy bear", 10.0)
        raise error

    code, report = _run(monkeypatch, tmp_path, story)
    assert code == 1
    assert report["notes"] == [str(error).splitlines()[0]]
    assert len(report["searches"]) == 1
    assert str(error) in capsys.readouterr().out


def test_exit_code_and_report_after_ctrl_c(monkeypatch, tmp_path):
    def story(demo):
        raise KeyboardInterrupt

    code, report = _run(monkeypatch, tmp_path, story)
    assert code == 130 and report["notes"] == ["The run was interrupted."]


def test_words_without_a_word_start_nothing(tmp_path):
    with pytest.raises(DemoError, match="empty"):
        run_demo(DemoConfig(objects=("desk", " "), out=tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_offload_starts_nothing(tmp_path):
    with pytest.raises(DemoError, match="never, auto, host"):
        run_demo(DemoConfig(offload="always", out=tmp_path))
    assert list(tmp_path.iterdir()) == []
