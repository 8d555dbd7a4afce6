"""With the import extra only: pairs of OpenCLIP's architectures with random weights."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
open_clip = pytest.importorskip("open_clip")
pytest.importorskip("onnx")

from tokenizers import Tokenizer  # noqa: E402

from edge.perception.session import open_session  # noqa: E402
from models.manifest import ModelError  # noqa: E402
from tools.models.pair import IMAGE, SALIENCY, TEXT, TOKENIZER  # noqa: E402
from tools.models.parity import PROMPTS, token_ids  # noqa: E402
from tools.models.source import open_source  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")

TEXT_TOWER = {"context_length": 77, "vocab_size": 49408, "width": 32, "heads": 4, "layers": 2}
CONFIGS = {
    "toy-vit": {"vision_cfg": {"image_size": 64, "layers": 2, "width": 64, "patch_size": 16, "head_width": 16}},
    "toy-resnet": {"vision_cfg": {"image_size": 64, "layers": [1, 1, 1, 1], "width": 8, "patch_size": None}},
    # As MobileCLIP's: a CNN of timm's, and a text tower that sees the whole prompt.
    "toy-mobile": {
        "vision_cfg": {"timm_model_name": "fastvit_mci0", "timm_pool": "avg", "timm_proj": None, "image_size": 64},
        "text_cfg": TEXT_TOWER | {"no_causal_mask": True},
        "custom_text": True,
    },
    # As TinyCLIP's: quick GELU, and a text tower of its own that does not.
    "toy-custom": {
        "vision_cfg": {"image_size": 48, "layers": 2, "width": 32, "patch_size": 16, "head_width": 16},
        "custom_text": True,
        "quick_gelu": True,
    },
}


@pytest.fixture(scope="module", autouse=True)
def known(tmp_path_factory):
    """OpenCLIP knows the toys."""
    folder = tmp_path_factory.mktemp("configs")
    for name, config in CONFIGS.items():
        whole = {"embed_dim": 24, "text_cfg": TEXT_TOWER} | config
        (folder / f"{name}.json").write_text(json.dumps(whole))
    open_clip.add_model_config(folder)


@pytest.fixture
def checkpoint(tmp_path):
    """Saves a toy with random weights."""

    def save(name):
        torch.manual_seed(0)
        torch.save(open_clip.create_model(name).state_dict(), tmp_path / f"{name}.pt")
        return tmp_path / f"{name}.pt"

    return save


@pytest.mark.parametrize(
    ("name", "maps", "pad"),
    [
        ("toy-vit", {"patches": (64, 4, 4), "others": (64, 1, 1)}, None),
        ("toy-resnet", {"features": (256, 2, 2)}, None),
        ("toy-mobile", {"features": (1024, 2, 2)}, 0),
        ("toy-custom", {"patches": (32, 3, 3), "others": (32, 1, 1)}, None),
    ],
)
def test_the_exported_towers_are_open_clips(name, maps, pad, checkpoint, tmp_path):
    pair = open_source(name, checkpoint(name))
    pair.export(tmp_path)
    assert pair.pad_id == pad and pair.context_length == 77 and pair.logit_scale == pytest.approx(1 / 0.07)
    model = open_clip.create_model(name, str(tmp_path / f"{name}.pt")).eval()
    image = np.random.default_rng(0).normal(size=(1, 3, pair.height, pair.width)).astype(np.float32)
    session = open_session(tmp_path / IMAGE)
    vectors, *features = session.run(None, {"image": image})
    with torch.no_grad():
        expected = model.encode_image(torch.tensor(image), normalize=True).numpy()
        prompts = model.encode_text(open_clip.get_tokenizer(name)(list(PROMPTS)), normalize=True).numpy()
    np.testing.assert_allclose(vectors, expected, atol=1e-5)
    assert {o.name: f.shape[1:] for o, f in zip(session.get_outputs()[1:], features)} == maps
    assert {i.name for i in open_session(tmp_path / SALIENCY).get_inputs()} == {"direction", *maps}
    text = open_session(tmp_path / TEXT)
    for ids, expected in zip(token_ids(pair, tmp_path / TOKENIZER), prompts):
        np.testing.assert_allclose(text.run(None, {"input_ids": ids})[0][0], expected, atol=1e-5)


def test_a_prompt_that_is_too_long(checkpoint, tmp_path):
    pair = open_source("toy-vit", checkpoint("toy-vit"))
    pair.export(tmp_path)
    tokenizer = Tokenizer.from_file(str(tmp_path / TOKENIZER))
    tokenizer.enable_truncation(pair.context_length)
    long = "a chair and a table " * 100
    (found,) = open_session(tmp_path / TEXT).run(None, {"input_ids": np.array([tokenizer.encode(long).ids])})
    np.testing.assert_allclose(found[0], pair.read(long), atol=1e-5)


def test_a_folder_as_open_clip_puts_it_on_a_hub(tmp_path):
    config = {"embed_dim": 24, "text_cfg": TEXT_TOWER} | CONFIGS["toy-vit"]
    settings = {"mean": [0.1, 0.2, 0.3], "std": [0.4, 0.5, 0.6], "resize_mode": "squash"}
    (tmp_path / "open_clip_config.json").write_text(json.dumps({"model_cfg": config, "preprocess_cfg": settings}))
    torch.save(open_clip.create_model("toy-vit").state_dict(), tmp_path / "open_clip_pytorch_model.bin")
    (tmp_path / "README.md").write_text("---\nlicense: mit\n---\n# A model\n")
    pair = open_source(str(tmp_path))
    assert pair.mean == (0.1, 0.2, 0.3) and pair.std == (0.4, 0.5, 0.6) and pair.licence == "mit"


@pytest.mark.parametrize("clean", ["canonicalize", "lower", "whitespace"])
def test_a_tokenizer_of_hugging_faces(clean, tmp_path):
    transformers = pytest.importorskip("transformers")
    from tokenizers import models, pre_tokenizers, processors

    known = {word for prompt in PROMPTS for word in prompt.lower().replace(",", "").split()}
    words = ["<pad>", "</s>", "<unk>", *sorted(known)]
    inner = Tokenizer(models.WordLevel({word: i for i, word in enumerate(words)}, "<unk>"))
    inner.pre_tokenizer = pre_tokenizers.WhitespaceSplit()
    inner.post_processor = processors.TemplateProcessing(single="$A </s>", special_tokens=[("</s>", 1)])
    specials = {"pad_token": "<pad>", "eos_token": "</s>", "unk_token": "<unk>"}
    transformers.PreTrainedTokenizerFast(tokenizer_object=inner, **specials).save_pretrained(tmp_path)
    text = TEXT_TOWER | {"no_causal_mask": True, "pool_type": "last", "proj_bias": True, "vocab_size": len(words)}
    text |= {"hf_tokenizer_name": "someone/else", "tokenizer_kwargs": {"clean": clean}, "context_length": 24}
    config = {"embed_dim": 24, "text_cfg": text, "custom_text": True} | CONFIGS["toy-vit"]
    (tmp_path / "open_clip_config.json").write_text(json.dumps({"model_cfg": config, "preprocess_cfg": {}}))
    (tmp_path / "toy-hf.json").write_text(json.dumps(config))
    open_clip.add_model_config(tmp_path / "toy-hf.json")
    torch.save(open_clip.create_model("toy-hf").state_dict(), tmp_path / "open_clip_pytorch_model.bin")
    pair = open_source(str(tmp_path))
    assert pair.pad_id == 0
    (tmp_path / "out").mkdir()
    pair.export(tmp_path / "out")
    tower = open_session(tmp_path / "out" / TEXT)
    for prompt, ids in zip(PROMPTS, token_ids(pair, tmp_path / "out" / TOKENIZER)):
        np.testing.assert_allclose(tower.run(None, {"input_ids": ids})[0][0], pair.read(prompt), atol=1e-5)


def test_weights_must_be_stated(tmp_path):
    with pytest.raises(ModelError, match="RN50@TAG with one of openai, yfcc15m, cc12m, or --checkpoint"):
        open_source("RN50")
    with pytest.raises(ModelError, match="RN50@TAG"):
        open_source("RN50@nothing")
    with pytest.raises(ModelError, match="no checkpoint"):
        open_source("RN50", tmp_path / "nothing.pt")


def test_weights_that_do_not_fit(checkpoint, tmp_path):
    with pytest.raises(ModelError, match="toy-resnet.*cannot be loaded"):
        open_source("toy-resnet", checkpoint("toy-vit"))
    (tmp_path / "noise.pt").write_bytes(b"noise")
    with pytest.raises(ModelError, match="toy-vit.*cannot be loaded"):
        open_source("toy-vit", tmp_path / "noise.pt")
