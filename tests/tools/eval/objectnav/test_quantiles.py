"""Fig. 3 of [U]: how straight a sample lies on normal quantiles."""

import json

import numpy as np
import pytest
from scipy import stats

from edge.perception.prompts import ENSEMBLE
from tools.eval.objectnav import command
from tools.eval.objectnav.quantiles import COUNTS, draw, normal_quantiles, similarities, straightness, wordings


def test_a_hundred_wordings_are_all_different_and_begin_with_the_ensemble():
    texts = wordings()
    assert len(set(texts)) == len(texts) == max(COUNTS) and tuple(texts[: len(ENSEMBLE)]) == ENSEMBLE
    assert all(text.count("{}") == 1 for text in texts)


@pytest.mark.parametrize("count", COUNTS)
def test_normal_quantiles_are_scipys(count):
    assert normal_quantiles(count) == pytest.approx(stats.norm.ppf((np.arange(count) + 0.5) / count))


def test_straightness_is_a_probability_plots_correlation():
    rng = np.random.default_rng(0)
    samples = {"normal": rng.normal(size=(50, 100)), "skewed": rng.exponential(size=(50, 100)) ** 2}
    found = {name: straightness(np.sort(rows)) for name, rows in samples.items()}
    theirs = np.mean([stats.probplot(row)[1][2] for row in samples["normal"]])  # with other plotting positions
    assert found["normal"] == pytest.approx(theirs, abs=0.005)
    assert found["normal"] > 0.98 > 0.9 > found["skewed"]


def test_pictures_of_a_home_are_standardized_one_by_one(home, tmp_path):
    spreads = similarities([home], "lite0-minilm", 1, 0)
    assert list(spreads) == list(COUNTS)
    for count, values in spreads.items():
        assert values.shape == (8, count) and (np.diff(values) >= 0).all()
        assert values.mean(1) == pytest.approx(0, abs=1e-5) and values.std(1) == pytest.approx(1, abs=1e-5)
    draw(spreads, tmp_path / "qq.png")
    assert (tmp_path / "qq.png").stat().st_size > 1000


def test_the_command_says_how_straight_normal_samples_are(home, tmp_path, capsys):
    file = tmp_path / "qq.json"
    command.main(["--figure", "qq", "--homes", home, "--json", str(file)])
    found = {row["prompts"]: row for row in json.loads(file.read_text())}
    assert "100 prompts" in capsys.readouterr().out and list(found) == list(COUNTS)
    assert 0.95 < found[10]["normal"] < found[100]["normal"] < 1  # the more, the straighter
