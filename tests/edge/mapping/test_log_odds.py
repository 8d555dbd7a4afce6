import numpy as np
import pytest

from edge.mapping.log_odds import STEP, LogOddsConfig, count, update


def odds(p):
    return p / (1 - p)


def test_evidence_multiplies_the_odds():
    """Bayes in closed form: independent measurements multiply the odds of p(hit) = 0.70 and p(miss) = 0.40."""
    config = LogOddsConfig()
    layer = np.zeros((1, 3), np.int8)
    sequences = [(1, 1, 0), (0, 0, 1), (1, 0, 0)]
    for step in zip(*sequences):
        hit = np.array([step], np.uint8)
        update(layer, hit, 1 - hit, config)
    got = np.exp(layer[0] * STEP)
    wanted = [np.prod([odds(0.70) if hit else odds(0.40) for hit in sequence]) for sequence in sequences]
    np.testing.assert_allclose(got, wanted, rtol=0.05)


def test_a_hit_is_not_missed_in_the_same_measurement():
    layer = np.zeros((2, 2), np.int8)
    ones = np.ones((2, 2), np.uint8)
    update(layer, ones, ones, LogOddsConfig())
    assert (layer == count(0.85)).all()


def test_clamped_so_that_the_map_can_change():
    config = LogOddsConfig()
    layer = np.zeros((1, 1), np.int8)
    one, none = np.ones((1, 1), np.uint8), np.zeros((1, 1), np.uint8)
    for _ in range(1000):
        update(layer, one, none, config)
    assert layer[0, 0] == count(config.highest)
    misses = 0
    while layer[0, 0] > 0:
        update(layer, none, one, config)
        misses += 1
    assert misses == 9
    for _ in range(1000):
        update(layer, none, one, config)
    assert layer[0, 0] == count(config.lowest)


@pytest.mark.parametrize("wrong", [{"hit": 0.0}, {"miss": -1.0}, {"lowest": 0.5}, {"highest": 6.0}, {"lowest": -6.2}])
def test_settings_that_cannot_work_are_refused(wrong):
    with pytest.raises(ValueError, match="[Ll]og-odds"):
        LogOddsConfig(**wrong)
