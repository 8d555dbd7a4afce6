"""Acquisition functions against SciPy's normal distribution, and what they must prefer."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from edge.planning.acquisition import expected_improvement, upper_confidence_bound

beliefs = st.lists(st.tuples(st.floats(0, 1), st.floats(0, 0.5)), min_size=1, max_size=12).map(
    lambda pairs: np.array(pairs).T
)


@given(beliefs)
def test_expected_improvement_is_the_integral_over_what_exceeds_the_best(belief):
    means, variances = belief
    found = expected_improvement(means, variances)
    drawn = np.linspace(0.0005, 0.9995, 1000)
    for mean, variance, value in zip(means, variances, found):
        samples = norm.ppf(drawn, mean, np.sqrt(variance)) if variance > 0 else np.full(1000, mean)
        assert value == pytest.approx(np.maximum(samples - means.max(), 0).mean(), abs=2e-3)


@given(beliefs)
def test_upper_bound_is_that_many_deviations_above_the_mean(belief):
    means, variances = belief
    assert upper_confidence_bound(means, variances, 4.0) == pytest.approx(means + 2 * np.sqrt(variances))


def test_of_equal_means_the_less_known_is_preferred():
    for choose in (expected_improvement, upper_confidence_bound):
        assert choose([0.5, 0.5], [0.01, 0.2]).argmax() == 1


def test_of_equal_variances_the_higher_mean_is_preferred():
    for choose in (expected_improvement, upper_confidence_bound):
        assert choose([0.3, 0.6], [0.05, 0.05]).argmax() == 1
