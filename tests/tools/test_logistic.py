import numpy as np
import pytest
from sklearn.linear_model import LogisticRegression

from tools.logistic import logistic


def data(seed=0):
    rng = np.random.default_rng(seed)
    y = rng.random(3000) < 0.1
    return np.where(y, 0.35, 0.15) + rng.normal(0, 0.1, y.shape), y


def test_it_equals_scikit_learn_with_balanced_classes():
    x, y = data()
    theirs = LogisticRegression(C=1e9, class_weight="balanced", tol=1e-10)
    theirs.fit(x[:, None], y)
    slope, offset = logistic(x, y, balanced=True)
    assert slope == pytest.approx(theirs.coef_[0, 0], rel=1e-3)
    assert offset == pytest.approx(theirs.intercept_[0], abs=1e-3)


def test_it_equals_scikit_learn_with_a_penalty_and_two_kinds_of_evidence():
    x, y = data()
    both = np.column_stack([x, np.random.default_rng(1).normal(y, 2.0)])
    theirs = LogisticRegression(C=1 / 3, tol=1e-10).fit(both, y)
    *weights, offset = logistic(both, y, ridge=3.0)
    assert weights == pytest.approx(theirs.coef_[0], rel=1e-3)
    assert offset == pytest.approx(theirs.intercept_[0], rel=1e-3)


def test_one_class_is_refused():
    with pytest.raises(ValueError, match="needs both cases"):
        logistic(np.arange(3.0), np.ones(3, bool))
