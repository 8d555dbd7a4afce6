import numpy as np

from tools.assets.catalog import Entry
from tools.train.words import concept_vectors, imagenet_names, names, noun


def entry(name, *tags):
    size, rotation = (1, 1, 1), np.eye(3)
    return Entry("Toy", "x", name, tags, "Bedroom", size, None, None, rotation, False, False, "me", "CC0", "x.obj")


def test_numbers_at_the_end_are_no_part_of_the_noun():
    assert noun(entry("Apple iMac 2004")) == "apple imac"
    assert noun(entry("MP3 base")) == "mp3 base"


def test_tags_that_say_where_are_no_names():
    assert names(entry("Deck chair", "Seat", "Outdoor", "Garden", "Chair")) == ["deck chair", "seat", "chair"]


def test_a_thing_of_some_colour_is_that_thing():
    assert names(entry("Dark blue shelf", "Shelf")) == ["dark blue shelf", "shelf"]
    assert names(entry("White")) == ["white"]


def test_names_of_classes_follow_the_classifier(tmp_path):
    (tmp_path / "imagenet_lemmas.txt").write_text("n1\ttench, Tinca tinca\nn2\tgoldfish\n")
    (tmp_path / "imagenet_synsets.txt").write_text("n2\nn1\n")
    assert imagenet_names(tmp_path) == [["goldfish"], ["tench", "Tinca tinca"]]


def test_a_concept_is_the_unit_mean_of_its_names():
    def encode(texts):
        return np.array([[1.0, 0.0] if "cat" in text else [0.0, 1.0] for text in texts])

    mixed, pure = concept_vectors([["cat", "dog"], ["cat"]], encode)
    np.testing.assert_allclose(mixed, [0.5**0.5] * 2, rtol=1e-6)
    np.testing.assert_allclose(pure, [1, 0])
