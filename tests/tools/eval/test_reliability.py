"""Calibration, against scikit-learn and by drawing truths from stated confidences."""

from dataclasses import replace

import numpy as np
import pytest
from sklearn.calibration import calibration_curve
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import brier_score_loss

from edge.missions.map_home import HomeMapped
from models.manifest import Confidence, logit
from tests.tools.eval.test_table import RIGHT
from tools.eval import confidence
from tools.eval.campaign import HomeResult
from tools.eval.reliability import bins, brier, calibration_error, claims_of, draw, fit, seen, show
from tools.eval.spread import write


def claims(weights, count=400, seed=0):
    """Claims whose truth is drawn with the probability that ``weights`` give them."""
    rng = np.random.default_rng(seed)
    made = []
    for number in range(count):
        score, remembered = 1 / (1 + np.exp(-rng.normal(2, 2, 2)))
        stated = weights(score, remembered)
        right = bool(rng.uniform() < stated)
        evidence = {"score": float(score), "remembered": float(remembered), "confidence": stated}
        made.append(replace(RIGHT, home=str(number % 20), success=right, **evidence))
    return made


@pytest.fixture
def told():
    return claims(Confidence(0.7, 0.3, -1.5))


def test_bins_and_errors_are_scikit_learns(told):
    truth, stated = [e.success for e in told], [e.confidence for e in told]
    right, mean = calibration_curve(truth, stated, n_bins=5, strategy="quantile")
    found = bins(told)
    assert [b.right for b in found] == pytest.approx(right, abs=0.02)
    assert [b.stated for b in found] == pytest.approx(mean, abs=0.02)
    assert brier(told) == pytest.approx(brier_score_loss(truth, stated))


def test_true_probabilities_are_reliable_and_their_squares_are_not(told):
    assert calibration_error(bins(told)) < 0.06
    assert calibration_error(bins([replace(e, confidence=e.confidence**2) for e in told])) > 0.1


def test_intervals_hold_the_share(told):
    assert all(b.low <= b.right <= b.high and b.low < b.high for b in bins(told))


def test_the_fit_is_that_of_scikit_learn(told):
    design = [[logit(e.score), logit(e.remembered)] for e in told]
    other = LogisticRegression(tol=1e-10).fit(design, [e.success for e in told])
    found = fit(told)
    assert (found.seen, found.remembered) == pytest.approx(other.coef_[0], abs=2e-3)
    assert found.offset == pytest.approx(other.intercept_[0], abs=2e-3)


def test_claims_without_two_outcomes_cannot_be_fitted(told):
    with pytest.raises(ValueError, match="needs both cases"):
        fit([e for e in told if e.success])


def test_all_that_is_claimed_counts_and_what_was_seen_is_fitted(told):
    silent = replace(RIGHT, status="not found")
    guess = replace(RIGHT, score=float("nan"))
    pushed, helped = replace(RIGHT, disturbance="push"), replace(RIGHT, truth="detector")
    claims = claims_of([*told[:3], silent, guess, pushed, helped])
    assert claims == [*told[:3], guess] and seen(claims) == told[:3]
    assert "4 claims, 1 of them guesses" in show(claims)
    assert np.isnan(calibration_error(bins([]))) and "0 claims" in show([])


def test_the_command_reads_draws_and_writes(told, tmp_path, capsys):
    (tmp_path / "model").mkdir()
    model = tmp_path / "model"
    (model / "manifest.json").write_text(confidence.resolve().joinpath("manifest.json").read_text())
    result = HomeResult("a", HomeMapped(True, 1.0, 1.0, 1.0, 1), 1, 1, told)
    write([result], [], tmp_path / "e.json")
    confidence.main([str(tmp_path / "e.json"), "--picture", str(tmp_path / "r.png"), "--write", str(model)])
    assert "400 claims" in capsys.readouterr().out
    assert (tmp_path / "r.png").read_bytes().startswith(b"\x89PNG")
    assert confidence.Manifest.load(model).confidence == fit(told)


def test_a_file_of_something_else_is_refused_in_a_sentence(tmp_path, capsys):
    (tmp_path / "e.json").write_text("[{}]")
    with pytest.raises(SystemExit) as ended:
        confidence.main([str(tmp_path / "e.json")])
    assert ended.value.code == 2 and "does not hold the episodes" in capsys.readouterr().err


def test_a_picture_needs_no_claims(tmp_path):
    draw([], tmp_path / "empty.png")
    assert (tmp_path / "empty.png").exists()
