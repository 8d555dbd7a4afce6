"""DBSCAN against scikit-learn's, label by label."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from sklearn.cluster import DBSCAN

from edge.planning.dbscan import NOISE, dbscan

# Eighths have exact squares, so that ties at the radius fall the same way in both.
eighths = st.integers(-40, 40).map(lambda i: i / 8)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    arrays(float, st.tuples(st.integers(1, 60), st.integers(1, 4)), elements=eighths),
    st.sampled_from([0.5, 1.0, 1.5, 2.5]),
    st.integers(1, 6),
)
def test_equals_sklearn(points, radius, min_points):
    expected = DBSCAN(eps=radius, min_samples=min_points, algorithm="brute").fit_predict(points)
    np.testing.assert_array_equal(dbscan(points, radius, min_points), expected)


@pytest.mark.parametrize("seed", range(5))
def test_equals_sklearn_on_blobs(seed):
    rng = np.random.default_rng(seed)
    points = np.concatenate([rng.normal(centre, 0.4, (80, 3)) for centre in rng.uniform(-4, 4, (5, 3))])
    expected = DBSCAN(eps=0.4, min_samples=4).fit_predict(points)
    assert expected.max() >= 2 and (expected == NOISE).any()
    np.testing.assert_array_equal(dbscan(points, 0.4, 4), expected)


def test_no_points():
    assert dbscan(np.empty((0, 2)), 1.0, 2).shape == (0,)
