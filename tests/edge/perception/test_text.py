"""The text tower's feeding of its graph, against the shipped tower where that can be."""

import json
import shutil

import numpy as np
import pytest

from edge.perception import text as module
from edge.perception.text import TextTower
from models.manifest import Manifest, resolve


class Graph:
    """Stands in for a session; remembers what it was fed."""

    def __init__(self, *inputs):
        self.inputs, self.fed = inputs, []

    def get_inputs(self):
        return [type("Input", (), {"name": name}) for name in self.inputs]

    def run(self, outputs, feeds):
        self.fed.append(feeds)
        return [np.eye(1, 384, dtype=np.float32)]


@pytest.fixture
def tower(tmp_path, monkeypatch):
    """Makes a tower with the shipped tokenizer, changes to its manifest's text, and a graph with these inputs."""

    def make(graph, **changes):
        raw = json.loads((resolve() / "manifest.json").read_text())
        (tmp_path / "manifest.json").write_text(json.dumps(raw | {"text": raw["text"] | changes}))
        shutil.copy(resolve() / "tokenizer.json", tmp_path)
        monkeypatch.setattr(module, "open_session", lambda path, threads: graph)
        return TextTower(Manifest.load(tmp_path))

    return make


def test_prompts_are_not_filled_unless_the_manifest_says_so(tower):
    graph = Graph("input_ids", "attention_mask")
    tower(graph).encode(["a chair", "a red chair"])
    assert [feeds["input_ids"].shape for feeds in graph.fed] == [(1, 4), (1, 5)]
    assert all(feeds["attention_mask"].all() for feeds in graph.fed)


def test_a_tower_that_knows_one_length_gets_it(tower):
    graph = Graph("input_ids", "attention_mask")
    tower(graph, pad_id=7, context_length=6).encode(["a chair", "a chair " * 20])
    short, long = (feeds["input_ids"][0].tolist() for feeds in graph.fed)
    assert short[4:] == [7, 7] and len(long) == 6 and long[-1] == short[3] != 7
    assert graph.fed[0]["attention_mask"].tolist() == [[1, 1, 1, 1, 0, 0]]


def test_a_graph_without_a_mask_is_fed_none(tower):
    graph = Graph("input_ids")
    tower(graph).encode(["a chair"])
    assert list(graph.fed[0]) == ["input_ids"] and graph.fed[0]["input_ids"].dtype == np.int64


def test_it_is_open_while_it_encodes_only_unless_it_was_opened():
    tower = TextTower(Manifest.load(resolve()))
    once = tower.encode(["a chair"])
    assert tower._session is None and tower._tokenizer is None
    tower.open()
    session = tower._session
    assert np.array_equal(tower.encode(["a chair"]), once) and tower._session is session
