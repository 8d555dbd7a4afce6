import argparse

import pytest

from firmware_sim.seed import seed


def test_whole_numbers_from_0_on_are_seeds(capsys):
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=seed)
    assert parser.parse_args(["--seed", "12"]).seed == 12
    for wrong in ("-1", "1.5", "one", ""):
        with pytest.raises(SystemExit):
            parser.parse_args([f"--seed={wrong}"])
        assert f"{wrong} is no seed" in capsys.readouterr().err
