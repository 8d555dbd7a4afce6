import numpy as np
import pytest

from edge.perception.encoder import Encoder
from models.manifest import ModelError, resolve
from tools.models.reference import NAME, Reference, decode, encode, parity


@pytest.fixture(scope="module")
def encoder():
    return Encoder.load()


def unit(rng, *shape):
    rows = rng.normal(size=shape).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


def test_what_is_saved_is_loaded(tmp_path):
    rng = np.random.default_rng(0)
    jpegs = [encode(rng.integers(0, 256, (h, 40, 3), dtype=np.uint8)) for h in (20, 30)]
    saved = Reference(jpegs, unit(rng, 2, 4, 8), ["", "a cup", "椅子"], unit(rng, 3, 8))
    saved.save(tmp_path)
    loaded = Reference.load(tmp_path)
    assert loaded.jpegs == jpegs and loaded.prompts == saved.prompts
    assert [rgb.shape for rgb in loaded.pictures()] == [(20, 40, 3), (30, 40, 3)]
    np.testing.assert_allclose((loaded.image * saved.image).sum(-1), 1, atol=1e-3)
    np.testing.assert_allclose(loaded.text, saved.text, atol=1e-3)


def test_colours_stay_where_they_are():
    red = np.zeros((16, 16, 3), np.uint8)
    red[..., 0] = 200
    assert np.abs(decode(encode(red)).astype(int) - red).max() < 10


def test_a_model_may_have_none(tmp_path):
    assert Reference.load(tmp_path) is None


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x05\x06" + bytes(18)])
def test_a_broken_one_is_one_sentence(tmp_path, content):
    (tmp_path / NAME).write_bytes(content)
    with pytest.raises(ModelError, match="reference.npz cannot be read"):
        Reference.load(tmp_path)


def test_int8_is_close_to_float32_on_the_shipped_reference(encoder):
    """The issue's bar: median cosine of 0.98; the text tower's is held to the same."""
    reference = Reference.load(resolve())
    assert len(reference.jpegs) >= 16 and len(reference.prompts) >= 12
    found = parity(encoder, reference)
    assert found["image_parity"] >= 0.98 and found["text_parity"] >= 0.98
    assert found["image_parity_min"] >= 0.95


def test_a_spoilt_tower_shows(encoder):
    reference = Reference.load(resolve())
    swapped = Reference(reference.jpegs[::-1], reference.image, reference.prompts, -reference.text)
    found = parity(encoder, swapped)
    assert found["image_parity"] < 0.9 and found["text_parity"] < 0
