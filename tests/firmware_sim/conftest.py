"""A two-room house of plain boxes: exact geometry, so that sensors and physics can be checked by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from firmware_sim.house import House


def box(name, width, depth, height, top=None):
    """A FurnitureModel of which every number is known."""
    corners = np.array([[-width, -depth], [width, -depth], [width, depth], [-width, depth]]) / 2
    slices = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1) if height > 0.25 else np.zeros((0, 2, 2))
    return SimpleNamespace(
        id=name, name=name, category="Office", size=(width, depth, height), footprint=corners, slices=slices, top=top
    )


@pytest.fixture
def boxes():
    models = [
        box("table", 1.2, 0.6, 0.7, top=0.7),
        box("cube", 0.4, 0.4, 0.4),
        box("lamp", 0.2, 0.2, 0.5),
        box("shelf", 0.6, 0.3, 0.5),
    ]
    return {model.id: model for model in models}


@pytest.fixture
def plan():
    """A hall 4 m x 4 m and a den 3 m x 4 m east of it, joined by an open 0.9 m doorway at y = 2."""
    return {
        "name": "boxes",
        "rooms": [
            {"name": "hall", "category": "Living room", "polygon": [[0, 0], [4, 0], [4, 4], [0, 4]]},
            {"name": "den", "category": "Office", "polygon": [[4, 0], [7, 0], [7, 4], [4, 4]]},
        ],
        "walls": [
            {"a": [0, 0], "b": [7, 0]},
            {"a": [7, 0], "b": [7, 4]},
            {"a": [7, 4], "b": [0, 4]},
            {"a": [0, 4], "b": [0, 0]},
            {"a": [4, 0], "b": [4, 1.55]},
            {"a": [4, 2.45], "b": [4, 4]},
        ],
        "doors": [{"a": [4, 1.55], "b": [4, 2.45]}],
        "objects": [],
        "start": [1.0, 2.0, 0.0],
    }


@pytest.fixture
def empty(plan, boxes):
    return House.from_dict(plan, boxes)


@pytest.fixture
def furnished(plan, boxes):
    plan["objects"] = [
        {"id": "table-1", "model": "table", "position": [2.0, 3.6], "yaw": 0.0},
        {"id": "lamp-1", "model": "lamp", "position": [2.3, 3.6], "on": "table-1"},
        {"id": "cube-1", "model": "cube", "position": [6.0, 1.0], "yaw": 0.5},
        {"id": "shelf-1", "model": "shelf", "position": [5.5, 3.78], "elevation": 1.4},
    ]
    return House.from_dict(plan, boxes)
