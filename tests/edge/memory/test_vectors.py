import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.memory.vectors import Vectors, largest, quantize


def unit(rng, n, dim):
    rows = rng.normal(size=(n, dim)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def filled(rows, bearings=None):
    vectors = Vectors(rows.shape[1])
    vectors.append(np.arange(len(rows)), *quantize(rows), np.zeros(len(rows)) if bearings is None else bearings)
    return vectors


@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 8), dim=st.integers(1, 70))
def test_quantisation_is_within_half_a_step(seed, rows, dim):
    given_rows = np.random.default_rng(seed).normal(size=(rows, dim)).astype(np.float32)
    matrix, scales = quantize(given_rows)
    assert matrix.dtype == np.int8 and abs(matrix.astype(int)).max() <= 127
    assert (np.abs(matrix * scales[:, None] - given_rows) <= scales[:, None] * 0.501).all()


def test_a_zero_row_survives_quantisation():
    matrix, scales = quantize(np.zeros((1, 5)))
    assert not matrix.any() and not scales.any()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 600), st.sampled_from([8, 100, 384, 512]), st.integers(1, 60))
def test_search_against_float32_brute_force(seed, n, dim, k):
    rng = np.random.default_rng(seed)
    rows, query = unit(rng, n, dim), unit(rng, 1, dim)[0]
    hits = filled(rows).search(query, k)
    exact = rows @ query
    best = np.argsort(-exact)[:k]
    assert len(hits.ids) == min(k, n) == len(set(hits.ids.tolist()))
    assert (np.diff(hits.scores) <= 0).all()
    # Half a quantisation step per component, seen through a unit query: at most |row - row'| = step / 2 * sqrt(dim).
    tolerance = np.abs(rows).max() / 127 / 2 * np.sqrt(dim) + 1e-5
    np.testing.assert_allclose(hits.scores, exact[hits.ids], atol=tolerance)
    assert exact[hits.ids].min() >= exact[best].min() - 2 * tolerance - 0.01


def test_of_equal_views_the_first_are_found():
    rows = np.repeat(unit(np.random.default_rng(5), 2, 8), 40, axis=0)  # two pictures, each seen 40 times
    assert filled(rows).search(rows[0], 50).ids[:40].tolist() == list(range(40))
    assert filled(rows).search(np.zeros(8), 50).ids.tolist() == list(range(50))


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3000), st.integers(1, 80), st.integers(1, 10_000), st.booleans())
def test_the_largest_of_many_with_ties(seed, n, k, distinct, alike_together):
    rng = np.random.default_rng(seed)
    values = rng.integers(0, distinct, n).astype(np.float32)
    values[rng.random(n) < 0.1] = -np.inf  # forgotten
    values = np.sort(values)[::-1] if alike_together else values
    k = min(k, n)
    assert largest(values, k).tolist() == sorted(range(n), key=lambda row: -values[row])[:k]


def test_recall_at_50_of_twenty_thousand():
    rng = np.random.default_rng(4)
    rows = unit(rng, 20_000, 512)
    vectors = filled(rows)
    recalls = []
    for query in unit(rng, 20, 512):
        best = set(np.argsort(-(rows @ query))[:50].tolist())
        recalls.append(len(best & set(vectors.search(query, 50).ids.tolist())) / 50)
    assert np.mean(recalls) >= 0.98


def test_scores_keep_the_length_of_the_direction():
    rows = unit(np.random.default_rng(0), 50, 384)
    direction = rows[3] - rows[4]
    hits = filled(rows).search(direction, 1)
    assert hits.ids[0] == 3
    assert hits.scores[0] == pytest.approx(float(rows[3] @ direction), abs=0.005)


def test_growth_keeps_rows_and_stays_within_the_budget():
    rng = np.random.default_rng(1)
    rows = unit(rng, 3000, 384)
    vectors = Vectors(384)
    for node, row in enumerate(rows):
        vectors.append(node, *quantize(row), [0.0])
        if node > 500:
            assert vectors.nbytes <= 1.5 * 384 * (node + 1)
    for node in (0, 1500, 2999):
        np.testing.assert_allclose(vectors.of(node)[0][0], rows[node], atol=0.002)


def test_forgotten_rows_answer_no_more_and_give_their_memory_back():
    rng = np.random.default_rng(2)
    rows = unit(rng, 400, 64)
    vectors = filled(rows, np.arange(400) / 400)
    for node in range(0, 400, 2):
        vectors.forget(node)
    assert len(vectors) == 200
    assert vectors._count < 300  # white box: compaction happened
    hits = vectors.search(rows[100], 400)
    assert len(hits.ids) == 200 and (hits.ids % 2 == 1).all()
    for node in (1, 201, 399):
        assert vectors.search(rows[node], 1).ids[0] == node
        np.testing.assert_allclose(vectors.of(node)[1], [node / 400], atol=1e-6)
    assert len(vectors.of(100)[0]) == 0
    vectors.forget(100)  # twice is once
    assert len(vectors) == 200


def test_cosines_region_by_region():
    rng = np.random.default_rng(3)
    rows, asked = unit(rng, 5, 64), unit(rng, 3, 64)
    vectors = Vectors(64)
    vectors.append(4, *quantize(rows[:2]), [0.0, 0.0])
    vectors.append(7, *quantize(rows[2:]), [0.0, 0.0, 0.0])
    cosines = vectors.cosines(np.array([7, 4]), asked)
    np.testing.assert_allclose(cosines[0], np.einsum("rd,rd->r", rows[2:], asked), atol=0.005)
    np.testing.assert_allclose(cosines[1, :2], np.einsum("rd,rd->r", rows[:2], asked[:2]), atol=0.005)
    assert np.isnan(cosines[1, 2])


def test_empty_memory_and_no_hits_wanted():
    assert len(Vectors(16).search(np.ones(16), 5).ids) == 0
    assert len(filled(np.eye(4)).search(np.ones(4), 0).ids) == 0


@pytest.mark.parametrize("direction, message", [(np.ones(5), "vectors of 4"), (np.full(4, np.nan), "NaN")])
def test_bad_directions_are_refused(direction, message):
    with pytest.raises(ValueError, match=message):
        filled(np.eye(4)).search(direction, 1)


def test_likeness_is_that_of_the_region_that_differs_most():
    vectors, rng = Vectors(16), np.random.default_rng(4)
    views = [rng.normal(size=(count, 16)).astype(np.float32) for count in (4, 4, 2)]
    for node, view in zip((3, 5, 9), views):
        vectors.append(node, *quantize(view), np.zeros(len(view)))

    def least(a, b):
        ranks = min(len(a), len(b))
        cosines = (a[:ranks] * b[:ranks]).sum(1) / np.linalg.norm(a[:ranks], axis=1) / np.linalg.norm(b[:ranks], axis=1)
        return cosines.min()

    found = vectors.likeness(np.array([3, 9, 9]), np.array([5, 3, 9]))
    np.testing.assert_allclose(found, [least(views[0], views[1]), least(views[2], views[0]), 1.0], atol=0.02)
    assert np.isnan(vectors.cosines(np.array([9]), views[0])[0]).tolist() == [False, False, True, True]
