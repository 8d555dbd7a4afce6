import numpy as np
import pytest
from sklearn.linear_model import LogisticRegression

from tools.train.calibrate import logistic


def data(seed=0):
    rng = np.random.default_rng(seed)
    y = rng.random(3000) < 0.1
    return np.where(y, 0.35, 0.15) + rng.normal(0, 0.1, y.shape), y


def test_it_equals_scikit_learn_with_balanced_classes():
    x, y = data()
    theirs = LogisticRegression(C=1e9, class_weight="balanced", tol=1e-10)
    theirs.fit(x[:, None], y)
    slope, offset = logistic(x, y)
    assert slope == pytest.approx(theirs.coef_[0, 0], rel=1e-3)
    assert offset == pytest.approx(theirs.intercept_[0], abs=1e-3)


def test_one_class_is_refused():
    with pytest.raises(ValueError, match="needs both cases"):
        logistic(np.arange(3.0), np.ones(3, bool))
