"""With the import extra only: pairs of Hugging Face's architectures with random weights."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
transformers = pytest.importorskip("transformers")
pytest.importorskip("onnx")

from tokenizers import Tokenizer, models, normalizers, pre_tokenizers, processors  # noqa: E402
from torch.nn import functional  # noqa: E402

from edge.perception.session import open_session  # noqa: E402
from models.manifest import ModelError  # noqa: E402
from tools.models.pair import CLIP_MEAN, IMAGE, SALIENCY, TEXT, TOKENIZER  # noqa: E402
from tools.models.parity import PROMPTS, token_ids  # noqa: E402
from tools.models.source import open_source  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")

CONTEXT = 24
LAYERS = {"hidden_size": 32, "intermediate_size": 64, "num_hidden_layers": 2, "num_attention_heads": 4}


def tokenizer():
    """A word tokenizer: [CLS] words [SEP]."""
    specials = ["[PAD]", "[UNK]", "[CLS]", "[SEP]"]
    words = specials + sorted({word for prompt in PROMPTS for word in prompt.lower().replace(",", "").split()})
    inner = Tokenizer(models.WordLevel({word: i for i, word in enumerate(words)}, "[UNK]"))
    inner.normalizer, inner.pre_tokenizer = normalizers.Lowercase(), pre_tokenizers.BertPreTokenizer()
    inner.post_processor = processors.TemplateProcessing(
        single="[CLS] $A [SEP]", special_tokens=[("[CLS]", 2), ("[SEP]", 3)]
    )
    names = {"pad_token": "[PAD]", "unk_token": "[UNK]", "cls_token": "[CLS]", "sep_token": "[SEP]"}
    return transformers.PreTrainedTokenizerFast(tokenizer_object=inner, model_max_length=CONTEXT, **names), len(words)


def model(kind, words):
    torch.manual_seed(0)
    vision = LAYERS | {"image_size": 48, "patch_size": 16}
    text = LAYERS | {"vocab_size": words, "max_position_embeddings": CONTEXT, "projection_size": 32}
    if kind == "clip":
        text |= {"eos_token_id": 3, "bos_token_id": 2, "pad_token_id": 0}
        config = transformers.CLIPConfig(vision_config=vision, text_config=text, projection_dim=24)
        return transformers.CLIPModel(config)
    if kind == "siglip":
        return transformers.SiglipModel(transformers.SiglipConfig(vision_config=vision, text_config=text))
    config = transformers.BlipConfig(
        vision_config=vision, text_config=text | {"encoder_hidden_size": 32}, image_text_hidden_size=24
    )
    return transformers.BlipForImageTextRetrieval(config)


@pytest.fixture
def folder(tmp_path):
    """Saves a toy of a kind with random weights, as a hub has it."""

    def save(kind):
        words, count = tokenizer()
        words.save_pretrained(tmp_path / kind)
        made = model(kind, count).eval()
        made.save_pretrained(tmp_path / kind)
        return tmp_path / kind, made, words

    return save


def vectors(kind, made, words, image):
    """What the framework says of the image and of PROMPTS, by its documented use."""
    padding = "max_length" if kind == "siglip" else True
    tokens = words(list(PROMPTS), padding=padding, truncation=True, return_tensors="pt")
    tokens.pop("token_type_ids", None)
    with torch.no_grad():
        if kind == "blip":
            scores = made(pixel_values=image, use_itm_head=False, **tokens)
            text = made.text_proj(scores.question_embeds[:, 0])
            seen = made.vision_proj(scores.last_hidden_state[:, 0])
            cosines = functional.normalize(seen, dim=-1) @ functional.normalize(text, dim=-1).T
            assert torch.allclose(cosines, scores.itm_score)
        else:
            seen = made.get_image_features(pixel_values=image).pooler_output
            if kind == "siglip":
                tokens.pop("attention_mask")
            text = made.get_text_features(**tokens).pooler_output
    return functional.normalize(seen, dim=-1).numpy(), functional.normalize(text, dim=-1).numpy()


@pytest.mark.parametrize(("kind", "maps", "pad"), [("clip", 2, None), ("siglip", 1, 0), ("blip", 2, None)])
def test_the_exported_towers_are_transformers(kind, maps, pad, folder, tmp_path):
    source, made, words = folder(kind)
    pair = open_source(str(source))
    pair.export(tmp_path)
    assert pair.pad_id == pad and pair.context_length == CONTEXT
    image = np.random.default_rng(0).normal(size=(1, 3, 48, 48)).astype(np.float32)
    session = open_session(tmp_path / IMAGE)
    found, *features = session.run(None, {"image": image})
    seen, read = vectors(kind, made, words, torch.tensor(image))
    np.testing.assert_allclose(found, seen, atol=1e-5)
    assert [f.shape for f in features] == [(1, 32, 3, 3), (1, 32, 1, 1)][:maps]
    names = {output.name for output in session.get_outputs()[1:]}
    assert {i.name for i in open_session(tmp_path / SALIENCY).get_inputs()} == {"direction", *names}
    text = open_session(tmp_path / TEXT)
    for ids, expected in zip(token_ids(pair, tmp_path / TOKENIZER), read):
        np.testing.assert_allclose(text.run(None, {"input_ids": ids})[0][0], expected, atol=1e-5)


def test_pixels_are_normalized_as_the_folder_says(folder):
    source, *_ = folder("clip")
    assert open_source(str(source)).mean == CLIP_MEAN
    (source / "preprocessor_config.json").write_text(json.dumps({"image_mean": [0.1] * 3, "image_std": [0.9] * 3}))
    pair = open_source(str(source))
    assert pair.mean == (0.1,) * 3 and pair.std == (0.9,) * 3


def test_a_model_of_another_kind(tmp_path):
    (tmp_path / "config.json").write_text('{"model_type": "bert"}')
    with pytest.raises(ModelError, match="is a bert model; of Hugging Face's, vlpg imports clip, siglip, blip"):
        open_source(str(tmp_path))
    (tmp_path / "config.json").write_text('{"model_type": "blip", "architectures": ["BlipForConditionalGeneration"]}')
    with pytest.raises(ModelError, match="take a BLIP for retrieval"):
        open_source(str(tmp_path))


@pytest.mark.parametrize("missing", ["model.safetensors", "tokenizer.json"])
def test_an_incomplete_folder(folder, missing):
    source, *_ = folder("clip")
    (source / missing).unlink()
    with pytest.raises(ModelError, match="cannot be loaded|no tokenizer.json|differently"):
        open_source(str(source)).export(source)


def test_a_damaged_folder(folder):
    source, *_ = folder("clip")
    (source / "model.safetensors").write_bytes(b"noise")
    with pytest.raises(ModelError, match="cannot be loaded"):
        open_source(str(source))
    (source / "config.json").write_text("{")
    with pytest.raises(ModelError, match="cannot be loaded"):
        open_source(str(source))
