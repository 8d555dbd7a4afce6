"""With the import extra only: the robot's tokenizer gives the ids of Hugging Face's SigLIP tokenizer."""

import json

import pytest

sentencepiece = pytest.importorskip("sentencepiece")
transformers = pytest.importorskip("transformers")
torch = pytest.importorskip("torch")

from tokenizers import Tokenizer  # noqa: E402

from tools.models.parity import PROMPTS  # noqa: E402
from tools.models.siglip_tokenizer import from_sentencepiece  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")

ODD = [
    "", " ", "a photo of a dog", "Two chairs & a TABLE; no. 42!", "  x \t y ", "é 椅子 dog", "A-B_c", "ＡＢ", "½ ﬁ",
    "a\n\nb", "a photo " * 30, "\U0001f9f8", "they're",
]  # fmt: skip


@pytest.fixture(scope="module")
def pieces(tmp_path_factory):
    """A small unigram model, as a repository keeps it."""
    folder = tmp_path_factory.mktemp("siglip")
    (folder / "words.txt").write_text("\n".join([*PROMPTS, "a photo of a dog", "two chairs"] * 20).lower())
    sentencepiece.SentencePieceTrainer.train(
        input=str(folder / "words.txt"), model_prefix=str(folder / "spiece"), vocab_size=90, model_type="unigram",
        pad_id=-1, bos_id=-1, eos_id=1, unk_id=2, control_symbols=["<z>"], hard_vocab_limit=False, minloglevel=2,
    )  # fmt: skip
    return folder / "spiece.model"


@pytest.mark.parametrize("text", ODD)
def test_the_ids_are_siglips(pieces, text):
    theirs = transformers.SiglipTokenizer(str(pieces), model_max_length=64)
    assert Tokenizer.from_str(from_sentencepiece(pieces)).encode(text).ids == theirs(text).input_ids


def test_a_repository_with_pieces_only(pieces, tmp_path):
    from tools.models.pair import TOKENIZER
    from tools.models.source import open_source

    words = transformers.SiglipTokenizer(str(pieces), model_max_length=64)
    words.save_pretrained(tmp_path)
    size = {"hidden_size": 32, "intermediate_size": 64, "num_hidden_layers": 1, "num_attention_heads": 4}
    text = size | {"vocab_size": len(words), "max_position_embeddings": 64, "projection_size": 32}
    config = transformers.SiglipConfig(text_config=text, vision_config=size | {"image_size": 32, "patch_size": 16})
    transformers.SiglipModel(config).save_pretrained(tmp_path)
    assert not (tmp_path / "tokenizer.json").exists()
    pair = open_source(str(tmp_path))
    assert pair.pad_id == 1 and pair.context_length == 64
    pair.export(tmp_path)
    assert json.loads((tmp_path / TOKENIZER).read_text())["model"]["type"] == "Unigram"
