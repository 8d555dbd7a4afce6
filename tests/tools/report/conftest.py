import cv2
import msgspec
import numpy as np
import pytest

from tools.report.record import Home, Hypothesis, Map, Mapping, Process, Replan, Run, Search, Thing

RESOLUTION = 0.05  # m
START = (1.0, 1.0, np.pi / 2)  # the map's x axis points up the plan


def _square(x0, y0, x1, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def _map(folder):
    """The robot's map of an 8 x 5 m home with one inner wall, in its own frame, started at START."""
    rows, cols = 160, 100  # map y = 1 - house x, map x = house y - 1
    grey = np.full((rows, cols), 128, np.uint8)
    grey[[0, -1]] = 255
    grey[:, [0, -1]] = 255
    grey[80, :60] = 255
    grey[130:, 70:-1] = 0
    assert cv2.imwrite(str(folder / "map.png"), grey)
    return Map("map.png", (rows, cols), (-1.0, 1.0 - 8.0), RESOLUTION)


@pytest.fixture
def search(tmp_path):
    likely = np.full((120, 120), 26, np.uint8)
    likely[30:60, 40:90] = 200
    assert cv2.imwrite(str(tmp_path / "replan.png"), likely)
    return Search(
        words="teddy bear",
        status="found",
        verdict="confirmed",
        remark="Teddy bear (teddy-bear-1) is 81 % visible.",
        duration=21.5,
        wall=6.0,
        distance=7.25,
        hypotheses=[
            Hypothesis((5.0, 3.0, -0.6), 0.93, [(4.6, 3.2, -0.5), (5.0, 3.0, -0.6), (5.2, 3.3, -0.9)]),
            Hypothesis((2.0, 2.0, 2.4), 0.55, [(2.0, 2.0, 2.4)]),
        ],
        replans=[Replan(Map("replan.png", likely.shape, (-1.0, -6.0), RESOLUTION), (4.0, 3.0, -0.6))],
        path=[(1.0, 1.0), (1.0, 4.0), (5.0, 3.5), (5.2, 2.8)],
        pose=(5.2, 2.8, -0.7),
        position=(6.4, 1.7),
        true_positions=[(6.6, 1.6)],
        angular_error=0.031,
        visible=0.81,
        confidence=0.62,
        picture="picture-1.jpg",
        picture_size=(320, 240),
        box=(120.0, 90.0, 210.0, 200.0),
    )


@pytest.fixture
def run(tmp_path, search):
    """A run with one object found, one wrongly claimed and one not in memory; its pictures are in tmp_path."""
    picture = np.linspace(0, 255, 240 * 320 * 3).reshape(240, 320, 3).astype(np.uint8)
    assert cv2.imwrite(str(tmp_path / "picture-1.jpg"), picture)
    wrong = msgspec.structs.replace(
        search,
        words="plant",
        verdict="wrong",
        remark="No plant is in the picture.",
        position=(2.0, 4.0),
        true_positions=[(7.0, 4.2)],
        angular_error=None,
        path=[(5.2, 2.8), (2.0, 2.5)],
    )
    missing = Search(
        words="<script>alert(1)</script> & co",
        status="not in memory",
        verdict="no claim",
        remark="Nothing in this home is called that.",
        duration=0.1,
        wall=0.1,
        distance=0.0,
        hypotheses=[],
        replans=[],
        path=[],
        pose=None,
        position=None,
        true_positions=[],
        angular_error=None,
        visible=0.0,
        confidence=None,
        picture=None,
        picture_size=None,
        box=None,
    )
    times = [0.5 * i for i in range(40)]
    home = Home(
        name="cottage",
        rooms={"kitchen": _square(0, 0, 4, 5), "bedroom": _square(4, 0, 8, 5)},
        walls=[((0, 0), (8, 0)), ((8, 0), (8, 5)), ((8, 5), (0, 5)), ((0, 5), (0, 0)), ((4, 0), (4, 3))],
        things=[
            Thing("teddy-bear-1", "Teddy bear", _square(6.4, 1.4, 6.8, 1.8)),
            Thing("plant-1", "Plant", _square(6.8, 4.0, 7.2, 4.4)),
        ],
        start=START,
    )
    return Run(
        started="2026-01-02T03:04:05",
        command='vlpg demo --object "teddy bear"',
        seed=0,
        speed=4.0,
        offload="never",
        machine={"processor": "Example CPU, 2 cores", "memory": "24 GB", "system": "Linux 6.1"},
        versions={"vlpg-edge": "0.1.0", "python": "3.11.7"},
        wall=123.4,
        home=home,
        map=_map(tmp_path),
        mapping=Mapping(True, 36.0, 3, 31.5, 92.0, 23.0, [(1, 1), (1, 4), (3, 4.4), (5, 4), (7, 3), (7, 1), (5, 1)]),
        nodes=[(1.0, 1.0, 1.57), (1.0, 3.0, 0.4), (5.0, 4.0, -0.5), (5.0, 3.0, -0.6)],
        searches=[search, wrong, missing],
        processes=[
            Process("sim", 180.0, 150.0, 30.0, 210.0, times, [min(180.0, 60 + 8 * t) for t in times]),
            Process("robot", 131.2, 98.1, 33.1, 150.0, times, [min(131.2, 50 + 9 * t) for t in times]),
            Process("host", 88.0, 60.0, 28.0, 110.0, times, [min(88.0, 40 + 9 * t) for t in times]),
        ],
        notes=["Time ran out: 1 object was not asked for."],
    )
