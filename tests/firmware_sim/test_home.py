import shutil

import pytest

from firmware_sim.home import load_home
from firmware_sim.house import HOMES, HouseError


def test_a_home_by_name_by_file_and_by_seed(tmp_path):
    shutil.copy(HOMES / "cottage.json", tmp_path / "mine.json")
    assert load_home("cottage").to_dict() == load_home(str(tmp_path / "mine.json")).to_dict()
    assert load_home("generated:7").name == "home-7"


@pytest.mark.parametrize("home", ["generated:", "generated:seven", "generated:-1"])
def test_a_seed_is_a_number(home):
    with pytest.raises(HouseError, match="generated:5"):
        load_home(home)


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(HouseError, match="apartment, bungalow, cottage"):
        load_home("atlantis")
