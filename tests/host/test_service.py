from types import SimpleNamespace

import numpy as np
import pytest

from edge.link.exchange import NoAnswer
from edge.link.reports import graph_reply
from edge.link.requests import Array, EmbedText, Optimize, RequestError, Search, pack, unpack
from edge.memory.store import Vlpg
from host.service import HostService

DIM = 8
MANIFEST = SimpleNamespace(name="tower", digest="abc", dim=DIM, logit_scale=10.0)


class Tower:
    """Words are axes: a prompt is the unit vector of the last word it knows, and "else" is the last axis."""

    WORDS = ["cup", "sofa", "bed"]

    def encode(self, texts):
        rows = np.zeros((len(texts), DIM), np.float32)
        for row, text in zip(rows, texts, strict=True):
            row[next((i for i, word in enumerate(self.WORDS) if word in text), DIM - 1)] = 1.0
        return rows


@pytest.fixture
def robot():
    """A memory that has seen a cup, a sofa and a bed, and the means to be asleep."""
    memory = Vlpg.open(":memory:", "tower", "abc", DIM)
    for n in range(3):
        memory.add(n, (n, 0, 0), np.eye(3), np.eye(DIM)[[n]], [0.1 * n])
    return SimpleNamespace(memory=memory, asleep=False, digest="abc", asked=[])


@pytest.fixture
def service(robot):
    def fetch(name, request):
        if name != "robot1" or robot.asleep:
            raise NoAnswer("asleep")
        robot.asked.append(request.vectors_from)
        return graph_reply(robot.memory, SimpleNamespace(name="tower", digest=robot.digest), request.vectors_from)

    return HostService(Tower(), MANIFEST, fetch)


def test_text_is_encoded_for_robots_with_the_same_encoder(service):
    vectors = service.embed_text(EmbedText(["a cup", "a bed"], "abc")).vectors.numpy()
    np.testing.assert_array_equal(vectors, np.eye(DIM)[[0, 2]])
    with pytest.raises(RequestError, match="same --model") as caught:
        service.embed_text(EmbedText(["a cup"], "other"))
    assert caught.value.field == "digest"


def test_search_scores_the_two_prompts(service):
    reply = service.search(Search("sofa", k=2))
    assert reply.ids.numpy()[0] == 1 and reply.fresh and reply.nodes == 3
    expected = 1 / (1 + np.exp(-10.0 * np.array([1.0, 0.0])))  # softmax over cosines 1 and 0, then 0 and 0
    np.testing.assert_allclose(reply.scores.numpy(), expected, atol=1e-3)
    np.testing.assert_allclose(reply.poses.numpy()[0], [1, 0, 0])
    assert reply.bearings.numpy()[0] == pytest.approx(0.1)


def test_a_sleeping_robots_memory_is_still_searched(service, robot):
    service.search(Search("sofa"))
    robot.asleep = True
    reply = service.search(Search("bed", k=1))
    assert reply.ids.numpy().tolist() == [2] and not reply.fresh


def test_only_new_nodes_are_fetched(service, robot):
    service.search(Search("sofa"))
    robot.memory.add(3.0, (5, 5, 0), np.eye(3), np.eye(DIM)[[0]], [0.0])
    assert service.search(Search("cup")).nodes == 4
    assert robot.asked == [0, 3]


@pytest.mark.parametrize("nodes", [1, 5])  # fewer than the old one, and more
def test_a_robot_with_a_new_memory_is_copied_anew(service, robot, nodes):
    service.search(Search("sofa"))
    robot.memory = Vlpg.open(":memory:", "tower", "abc", DIM)
    for n in range(nodes):
        robot.memory.add(n, (7 + n, 7, 0), np.eye(3), np.eye(DIM)[[2 + n]], [0.0])
    reply = service.search(Search("bed", k=1))
    assert reply.nodes == nodes and reply.poses.numpy()[0].tolist() == [7, 7, 0]


@pytest.mark.parametrize("name", ["*", "robot*", "a/**/b", "robot 1", "/robot", "a//b", "robot$1"])
def test_a_robots_name_has_no_wildcards(name):
    with pytest.raises(RequestError) as caught:
        unpack(Search, pack(Search("cup", robot=name)))
    assert caught.value.field == "robot"
    assert unpack(Search, pack(Search("cup", robot="fleet/robot-1"))).robot == "fleet/robot-1"


def test_what_cannot_be_searched_is_explained(service, robot):
    with pytest.raises(RequestError, match="robot9 does not answer"):
        service.search(Search("cup", robot="robot9"))
    robot.digest = "other"
    with pytest.raises(RequestError, match="encoder"):
        service.search(Search("cup"))


def test_a_graph_is_straightened(service):
    poses = np.array([[0.0, 0, 0], [1.2, 0, 0]])
    arrays = ([0, 1], poses, [[0, 1]], [[1.0, 0, 0]], np.eye(3)[None], [True])
    reply = service.optimize(Optimize(*(Array.of(np.array(array)) for array in arrays)))
    np.testing.assert_allclose(reply.poses.numpy(), [[0, 0, 0], [1, 0, 0]], atol=1e-6)
    assert reply.covariances.numpy().shape == (2, 3, 3)


def test_a_broken_graph_is_refused_in_words(service):
    arrays = ([0, 1], np.zeros((2, 3)), [[0, 9]], [[1.0, 0, 0]], np.eye(3)[None], [True])
    with pytest.raises(RequestError, match="not in the graph"):
        service.optimize(Optimize(*(Array.of(np.array(array)) for array in arrays)))
