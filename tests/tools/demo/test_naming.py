import pytest

from firmware_sim.house import House
from tools.demo.naming import DEFAULTS, default_objects, named


@pytest.fixture(scope="module")
def apartment():
    return House.load("apartment")


@pytest.mark.parametrize(
    ("words", "ids"),
    [
        ("teddy bear", {"teddy-bear-1"}),
        ("  The   Teddy BEAR ", {"teddy-bear-1"}),
        ("my brown teddy bear", {"teddy-bear-1"}),
        ("sofa", {"couch-1"}),  # a tag
        ("baby bed", {"baby-rocking-bed-1"}),  # the other beds are not meant
        ("tv", {"led-tv-1"}),  # nor the cabinet that is tagged so
        ("lamp", {"desklamp-1"}),
        ("desk", set()),  # a desk lamp is no desk
        ("elephant", set()),
        ("", set()),
    ],
)
def test_what_words_mean(apartment, words, ids):
    assert {thing.id for thing in named(apartment, words)} == ids


@pytest.mark.parametrize("home", sorted(DEFAULTS))
def test_each_default_is_in_its_home(home):
    house = House.load(home)
    assert len(DEFAULTS[home]) >= 5
    for words in DEFAULTS[home]:
        assert named(house, words), f"{home} has no {words}"


def test_another_home_is_asked_for_what_it_has(apartment):
    data = apartment.to_dict() | {"name": "elsewhere"}
    house = House.from_dict(data)
    objects = default_objects(house)
    assert len(objects) == len(set(objects)) == 6
    rooms = [house.room_at(thing.x, thing.y).name for words in objects for thing in named(house, words)[:1]]
    assert len(set(rooms)) >= 4
