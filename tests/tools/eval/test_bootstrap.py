import numpy as np
import pytest
from scipy import stats

from tools.eval.bootstrap import interval


def test_agrees_with_scipy_when_every_home_has_one_episode():
    values = np.random.default_rng(1).random(60)
    ours = interval(values, np.arange(60))
    theirs = stats.bootstrap((values,), np.mean, method="percentile", n_resamples=5000, rng=0).confidence_interval
    assert ours == pytest.approx(theirs, abs=0.01)


def test_episodes_of_one_home_stand_or_fall_together():
    values = np.repeat([0.0, 1.0], 50)
    apart, together = interval(values, np.arange(100)), interval(values, np.repeat([0, 1], 50))
    assert apart[1] - apart[0] < 0.25
    assert together == (0.0, 1.0)


def test_what_is_unknown_does_not_count():
    assert interval([np.nan, 2.0, 2.0], [0, 0, 1]) == (2.0, 2.0)
    assert np.isnan(interval([np.nan], [0])).all()
