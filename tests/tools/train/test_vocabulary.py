"""With the training extra installed only."""

import pytest

torch = pytest.importorskip("torch")

from tools.train.vocabulary import Vocabulary  # noqa: E402


def test_truth_neither_denies_synonyms_nor_what_is_hardly_visible(entry, encode):
    vocabulary = Vocabulary([entry(name) for name in ("lamp", "old lamp", "sofa", "fridge")], encode)
    vocabulary.cosines = torch.eye(4)
    fridge, lamp, old, sofa = range(4)
    vocabulary.cosines[lamp, old] = vocabulary.cosines[old, lamp] = 0.9
    named, doubtful = torch.zeros(1, 4, dtype=torch.bool), torch.zeros(1, 4, dtype=torch.bool)
    named[0, 0] = doubtful[0, 2] = True
    positive, negative = vocabulary.truth(named, doubtful, 0.65)
    assert positive[0].tolist() == [False, True, False, False]
    assert negative[0].tolist() == [True, False, False, False]


def test_a_model_is_called_by_its_name_and_by_the_tags_that_name_things(entry, encode):
    vocabulary = Vocabulary([entry("armchair", tags=("Seat", "Indoor"))], encode)
    assert vocabulary.names == ["armchair", "seat"] and vocabulary.called.tolist() == [[1, 1]]
