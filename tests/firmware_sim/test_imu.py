import numpy as np
import pytest

from firmware_sim.imu import Imu, ImuConfig


def test_a_perfect_part_tells_the_truth():
    sample = Imu(ImuConfig(), 0.02, None).read(1.0, 0.3, (0.1, -0.2))
    assert (sample.stamp, sample.turn_rate, sample.acceleration) == (1.0, 0.3, (0.1, -0.2))


def test_bias_and_noise_are_as_stated():
    config = ImuConfig()
    means = []
    for seed in range(40):
        imu = Imu(config, 0.02, np.random.default_rng(seed))
        rates = [imu.read(0.0, 0.0, (0.0, 0.0)).turn_rate for _ in range(100)]
        means.append(np.mean(rates))
        assert np.std(rates) == pytest.approx(config.gyro_noise, rel=0.4)
    assert np.std(means) == pytest.approx(config.gyro_bias, rel=0.4)
