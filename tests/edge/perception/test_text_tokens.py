"""Tokens of the shipped tower against Hugging Face's tokenizers, by their golden file and, where installed, live."""

from pathlib import Path

import numpy as np
import pytest

from edge.perception.text import TextTower
from models.manifest import Manifest, resolve
from tools.train.odd_strings import COUNT, odd_strings
from tools.train.token_golden import fingerprint, reference

# What makes the two tokenizers of Hugging Face disagree: the sigma at the end of a Greek word, whose lower case depends
# on its place, and a noncharacter, which one leaves out and the other calls unknown.
DISPUTED = set("Σ\ufffe")


@pytest.fixture(scope="module")
def tower():
    return TextTower(Manifest.load(resolve()))


@pytest.fixture(scope="module")
def golden():
    with np.load(Path(__file__).parent / "tokens_golden.npz") as file:
        return dict(file)


def rows(ids, lengths):
    return [row.tolist() for row in np.split(ids, np.cumsum(lengths.astype(int))[:-1])]


def test_the_strings_are_those_of_the_golden_file(golden):
    strings = odd_strings()
    assert len(set(strings)) == COUNT == 1000 and fingerprint(strings) == golden["fingerprint"]
    assert "" in strings and max(map(len, strings)) > 5000 and any("\ud83d" in text for text in strings)


def test_tokens_are_hugging_faces(tower, golden):
    """Its tokenizer in Python, and its tokenizer in Rust where those two disagree."""
    strings, expected = odd_strings(), rows(golden["ids"], golden["lengths"])
    disputed = golden["disputed"].tolist()
    for i, row in zip(disputed, rows(golden["disputed_ids"], golden["disputed_lengths"])):
        assert DISPUTED & set(strings[i])
        expected[i] = row
    assert len(disputed) < 0.06 * COUNT
    wrong = [ascii(text[:50]) for text, ids in zip(strings, expected, strict=True) if tower.tokens(text) != ids]
    assert not wrong


def test_tokens_are_what_transformers_says_now(tower):
    pytest.importorskip("transformers")
    python, rust = reference(Manifest.load(resolve()))
    for text in odd_strings():
        assert tower.tokens(text) == rust(text)
        assert tower.tokens(text) == python(text) or DISPUTED & set(text)


def test_the_context_is_never_exceeded_and_never_empty(tower):
    lengths = [len(tower.tokens(text)) for text in odd_strings()]
    assert min(lengths) == 2 and max(lengths) == 128


def test_nothing_is_opened_before_the_first_prompt():
    tower = TextTower(Manifest.load(resolve()))
    assert tower._session is None and tower._tokenizer is None
    assert tower.encode([]).shape == (0, 384) and tower._session is None
