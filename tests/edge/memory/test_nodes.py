import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edge.memory.nodes import Nodes


@given(st.lists(st.tuples(st.integers(1, 3), st.booleans(), st.booleans()), max_size=100), st.data())
def test_as_a_dict_would_have_it(steps, data):
    nodes, expected = Nodes(), {}
    for gap, answers, drop in steps:
        node = nodes.next + gap - 1
        nodes.append(node, (node, -node, 0.5), answers, node % 3, node % 5)
        expected[node] = answers
        if drop:
            victim = data.draw(st.sampled_from(sorted(expected)))
            nodes.drop(victim)
            del expected[victim]
    assert nodes.ids.tolist() == sorted(expected) and len(nodes) == len(expected)
    np.testing.assert_array_equal(nodes.poses[:, 1], -nodes.ids)
    assert nodes.answers.tolist() == [expected[node] for node in nodes.ids.tolist()]
    assert nodes.tours.tolist() == [node % 3 for node in nodes.ids.tolist()]
    assert nodes.reach[:, -1].tolist() == [node % 5 for node in nodes.ids.tolist()]
    assert nodes.rows(nodes.ids).tolist() == list(range(len(nodes)))


def test_what_is_not_there_is_named():
    nodes = Nodes()
    with pytest.raises(IndexError, match="has no nodes"):
        nodes.rows([0])
    for node in range(3):
        nodes.append(node, (0, 0, 0), True, 1, 0)
    nodes.drop(1)
    with pytest.raises(IndexError, match="nodes 0 to 2, and 1 is none"):
        nodes.rows([0, 1])
