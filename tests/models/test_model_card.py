"""The shipped card says what the manifest says, its pictures are there, and the model is as good as it has to be."""

import re

import pytest

from models.manifest import Manifest, resolve


@pytest.fixture(scope="module")
def manifest():
    return Manifest.load(resolve())


@pytest.fixture(scope="module")
def card(manifest):
    return (manifest.folder / "MODEL_CARD.md").read_text()


def test_it_is_the_card_of_these_weights(manifest, card):
    assert manifest.digest in card


def test_it_states_the_manifests_figures(manifest, card):
    measured = manifest.measured
    for kind, figure in (("int8", measured["top5"]), ("float32", measured["top5_float32"])):
        row = next(line for line in card.splitlines() if line.startswith(f"| {kind} |"))
        assert f"{100 * figure:.1f} %" in row
    assert f"{measured['encoder_memory']:.0f} MB" in card


def test_its_pictures_are_there_and_small(manifest, card):
    pictures = re.findall(r"!\[.+?\]\((.+?)\)", card)
    assert sorted(pictures) == sorted(path.name for path in manifest.folder.glob("*.jpg"))
    assert all((manifest.folder / name).stat().st_size <= 400_000 for name in pictures)


def test_int8_costs_little(manifest):
    """At most one point of top-5 against float32, and a median cosine of 0.98 to it."""
    measured = manifest.measured
    assert measured["top5_float32"] - measured["top5"] <= 0.01
    assert measured["image_parity"] >= 0.98 and measured["text_parity"] >= 0.98


def test_it_fits(manifest):
    """A process with the runtime and the image tower stays under 75 MB."""
    assert manifest.measured["image_memory"] < 75
