import math
from types import SimpleNamespace

import numpy as np

from tools.eval.naming import Answer, Vocabulary, confusions, said_too_often, share

NAMES = ["cup", "sofa", "bed", "lamp", "vase", "door", "rug"]


class Encoder:
    """Names are axes; a picture is of what its first pixel counts, and a little of the next name."""

    def encode_text(self, texts):
        assert all(text.startswith("A photo of ") for text in texts)
        return np.eye(len(NAMES), dtype=np.float32)[[NAMES.index(text.removeprefix("A photo of ")) for text in texts]]

    def encode_image(self, rgb):
        vector = np.zeros((1, len(NAMES)), np.float32)
        vector[0, rgb[0, 0, 0]], vector[0, (rgb[0, 0, 0] + 1) % len(NAMES)] = 1.0, 0.5
        return SimpleNamespace(vectors=vector)


def ask(shows, truths):
    return Vocabulary(Encoder(), [*NAMES, "cup"]).ask("a.png", np.full((2, 2, 3), shows, np.uint8), truths)


def test_names_are_ranked():
    answer = ask(2, ("bed",))
    assert (answer.rank, answer.truth, answer.picture) == (0, "bed", "a.png")
    assert answer.best[:2] == ("bed", "lamp") and len(answer.best) == 5
    assert ask(2, ("lamp",)).rank == 1


def test_any_of_several_right_names_will_do():
    assert ask(2, ("vase", "lamp")).rank == 1
    assert ask(2, ("vase", "lamp")).truth == "vase"


def answers(*pairs):
    return [Answer(f"{i}.png", truth, int(truth != said), (said, truth)) for i, (truth, said) in enumerate(pairs)]


def test_shares_count_ranks():
    found = answers(("cup", "cup"), ("cup", "bed"), ("rug", "rug"), ("rug", "rug"))
    assert share(found, 1) == 0.75 and share(found, 2) == 1.0 and math.isnan(share([], 1))


def test_confusions_are_counted_and_ties_are_in_order_of_the_alphabet():
    found = answers(("cup", "vase"), ("bed", "sofa"), ("bed", "sofa"), ("rug", "sofa"), ("rug", "rug"), ("cup", "bed"))
    assert confusions(found, 3) == [("bed", "sofa", 2), ("cup", "bed", 1), ("cup", "vase", 1)]
    assert said_too_often(found, 1) == [("sofa", 3)]
