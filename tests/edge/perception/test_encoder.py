"""The shipped pair, end to end, and its saliency against PyTorch's autograd (golden file of `tools.train`)."""

from pathlib import Path

import numpy as np
import pytest

from edge.perception.encoder import Encoder, View
from edge.perception.prompts import Target
from models.manifest import Manifest, ModelError, resolve

GOLDEN = Path(__file__).parent / "encoder_golden.npz"


@pytest.fixture(scope="module")
def encoder():
    return Encoder.load()


@pytest.fixture(scope="module")
def golden():
    with np.load(GOLDEN) as file:
        return dict(file)


def picture(seed=0):
    return np.random.default_rng(seed).integers(0, 256, (240, 320, 3), dtype=np.uint8)


def test_a_view_has_unit_vectors_bearings_and_features(encoder):
    view = encoder.encode_image(picture())
    assert view.vectors.shape == (4, encoder.dim) and view.vectors.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(view.vectors, axis=1), 1, atol=1e-5)
    assert [features.shape for features in view.features] == [(1280, 7, 9), (256, 14, 18)]


def test_more_threads_say_the_same(encoder):
    one, two = encoder.encode_image(picture()), Encoder.load(text=False, threads=2).encode_image(picture())
    np.testing.assert_allclose(two.vectors, one.vectors, atol=1e-6)


def test_bearings_point_at_the_middles_of_the_thirds(encoder):
    view = encoder.encode_image(picture(), hfov=np.radians(79))
    whole, left, middle, right = view.bearings
    assert whole == middle == 0
    assert left == pytest.approx(np.arctan(2 / 3 * np.tan(np.radians(39.5)))) and right == pytest.approx(-left)


@pytest.mark.parametrize(
    "rgb",
    [
        np.zeros((240, 320, 3), np.uint8),
        np.full((240, 320, 3), 255, np.uint8),
        np.zeros((1, 1, 3), np.uint8),
        picture()[:37, :500],
    ],
)
def test_odd_pictures_give_finite_unit_vectors(encoder, rgb):
    view = encoder.encode_image(rgb)
    np.testing.assert_allclose(np.linalg.norm(view.vectors, axis=1), 1, atol=1e-5)
    target = Target.of("lamp", encoder)
    assert np.isfinite(encoder.saliency(view, target.direction)).all()


def test_a_part_of_the_picture_changes_only_its_own_region(encoder):
    before = picture()
    after = before.copy()
    after[:, 240:] = 127
    vectors = [encoder.encode_image(rgb).vectors for rgb in (before, after)]
    change = np.linalg.norm(vectors[0] - vectors[1], axis=1)
    assert change[3] > 2 * change[1]


def test_the_vectors_equal_those_of_the_training_side(encoder, golden):
    """Preprocessing, trunk and head: PyTorch in float32 against int8 here."""
    for rgb, expected in zip(golden["pictures"], golden["vectors"]):
        cosines = (encoder.encode_image(rgb).vectors * expected).sum(1)
        assert cosines.min() > 0.95 and np.median(cosines) > 0.98


def test_saliency_is_autograds(encoder, golden):
    for *maps, direction, expected in zip(*(golden[name] for name in ("deep", "detail", "directions", "saliency"))):
        maps = tuple(features.astype(np.float32) for features in maps)
        view = View(np.zeros((4, encoder.dim), np.float32), np.zeros(4), maps)
        np.testing.assert_allclose(encoder.saliency(view, direction), expected, atol=1e-4 * expected.max(), rtol=0)


def test_saliency_is_zero_for_black_feature_maps(encoder):
    maps = np.zeros((1280, 7, 9), np.float32), np.zeros((256, 14, 18), np.float32)
    view = View(np.zeros((4, encoder.dim), np.float32), np.zeros(4), maps)
    assert not encoder.saliency(view, np.ones(encoder.dim, np.float32)).any()


def test_prompts_become_unit_vectors_that_depend_on_nothing_else(encoder):
    alone = encoder.encode_text(["a chair"])
    among = encoder.encode_text(["", "a chair", "a much longer prompt about a chair and a table"])
    np.testing.assert_array_equal(alone[0], among[1])
    np.testing.assert_allclose(np.linalg.norm(among, axis=1), 1, atol=1e-5)
    assert encoder.encode_text([]).shape == (0, encoder.dim)


@pytest.mark.parametrize("text", ["", "\U0001f9f8", "\ud83d", "椅子", "x" * 5000, "\0", "A PHOTO of ÉCLAIR\n"])
def test_odd_prompts_are_survived(encoder, text):
    assert np.linalg.norm(encoder.encode_text([text])) == pytest.approx(1, abs=1e-5)


def test_synonyms_are_nearer_than_other_things(encoder):
    sofa, couch, fridge = encoder.encode_text(["a sofa", "a couch", "a refrigerator"])
    assert sofa @ couch > sofa @ fridge + 0.2


def test_without_the_text_tower_prompts_are_refused():
    with pytest.raises(ModelError, match="without its text tower"):
        Encoder.load(text=False).encode_text(["a chair"])


def test_a_model_that_came_without_its_text_tower_encodes_pictures_and_is_not_whole(encoder, tmp_path):
    manifest = Manifest.load(resolve())
    for name in ("manifest.json", *(file.name for file in manifest.image_files)):
        (tmp_path / name).symlink_to(manifest.folder / name)
    view = Encoder.load(tmp_path, text=False).encode_image(picture())
    assert (view.vectors == encoder.encode_image(picture()).vectors).all()
    with pytest.raises(ModelError, match="text.onnx is missing|tokenizer.json is missing"):
        Encoder.load(tmp_path)


def test_an_unknown_model_is_one_sentence():
    with pytest.raises(ModelError, match="no model named nothing"):
        Encoder.load("nothing")


def test_the_digest_is_the_manifests(encoder):
    assert len(encoder.digest) == 64 and encoder.name == resolve().name
