import pytest

from models.manifest import Manifest, resolve
from tools.models.verify import LABELS, compare, sound

CARD = {
    "image_parity": 0.995, "image_parity_min": 0.98, "text_parity": 0.99, "image_memory": 70.0, "size": 34.2,
    "encoder_memory": 90.0, "text_memory": 77.0,
    "image_p50": 10.0, "image_p95": 11.0, "text_p50": 2.0, "text_p95": 3.0,
}  # fmt: skip


def test_the_same_figures_are_sound_and_all_are_shown():
    rows = compare(CARD, CARD)
    assert sound(rows) and len(rows) == len(LABELS)
    assert [row.verdict for row in rows].count("ok") == 7


@pytest.mark.parametrize(
    ("change", "agrees"),
    [
        ({"image_parity": 0.9901}, True),
        ({"image_parity": 0.9899}, False),
        ({"image_parity": 1.0, "image_memory": 30.0}, True),
        ({"text_parity": 0.5}, False),
        ({"image_memory": 80.0}, True),
        ({"image_memory": 81.0}, False),
        ({"encoder_memory": 104.0}, False),
        ({"size": 34.3}, False),
        ({"image_p50": 500.0, "text_p95": 900.0}, True),
    ],
)
def test_parity_memory_and_size_are_judged_and_speed_is_not(change, agrees):
    assert sound(compare(CARD, CARD | change)) == agrees


def test_a_card_that_says_nothing_is_not_contradicted():
    rows = compare({}, CARD)
    assert sound(rows) and "does not say" in str(rows[0])


def test_a_figure_that_can_no_longer_be_measured_differs():
    rows = compare(CARD, {name: value for name, value in CARD.items() if "parity" not in name})
    assert not sound(rows) and "no reference.npz" in str(rows[0])


def test_the_shipped_card_states_every_figure():
    assert set(LABELS) <= set(Manifest.load(resolve()).measured)
