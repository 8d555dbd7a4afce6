import numpy as np
import pytest

from firmware_sim.house import House
from firmware_sim.world import World
from tools.eval.oracle import OracleEncoder

PLAN = {
    "name": "one room",
    "rooms": [{"name": "hall", "category": "Living room", "polygon": [[0, 0], [5, 0], [5, 4], [0, 4]]}],
    "walls": [{"a": a, "b": b} for a, b in (([0, 0], [5, 0]), ([5, 0], [5, 4]), ([5, 4], [0, 4]), ([0, 4], [0, 0]))],
    "doors": [],
    "objects": [
        {"id": "teddy-1", "model": "teddy-bear", "position": [3.0, 2.3]},
        {"id": "armchair-1", "model": "armchair", "position": [4.0, 1.6]},
    ],
    "start": [1.0, 2.0, 0.0],
}


@pytest.fixture(scope="module")
def world():
    world = World(House.from_dict(PLAN), 0)
    while world.picture is None:
        world.step(None)
    return world


@pytest.fixture(scope="module")
def encoder(world):
    return OracleEncoder(world)


def directions(encoder, *nouns):
    *rows, other = encoder.encode_text([f"A photo of {noun}" for noun in nouns] + ["A photo of something else"])
    return np.array(rows) - other


def test_what_the_picture_shows_beats_what_it_does_not(world, encoder):
    view = encoder.encode_image(world.picture.rgb)
    teddy, armchair, piano = (view.vectors @ directions(encoder, "teddy bear", "armchair", "piano").T)[0]
    assert teddy > 0 and armchair > 0 > piano


def test_saliency_lies_on_the_thing(world, encoder):
    view = encoder.encode_image(world.picture.rgb)
    saliency = encoder.saliency(view, directions(encoder, "teddy bear")[0])
    rows, cols = np.nonzero(world.picture.instances == world.object_ids.index("teddy-1"))
    peak = np.unravel_index(saliency.argmax(), saliency.shape)
    cells = encoder.CELLS
    assert rows.min() <= (peak[0] + 0.5) * 240 / cells[0] <= rows.max()
    assert cols.min() <= (peak[1] + 0.5) * 320 / cells[1] <= cols.max()
