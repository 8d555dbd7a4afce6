"""SigLIP's tokenizer, which is kept in SentencePiece's format, in the form that the robot's tokenizer reads."""

import string
from pathlib import Path

from tokenizers import Regex, Tokenizer, models, normalizers, pre_tokenizers, processors


def from_sentencepiece(model: Path, end: str = "</s>") -> str:
    """A ``tokenizers`` file: lower case, no punctuation, single spaces; ``end`` behind every prompt.

    Raises:
        ModuleNotFoundError: sentencepiece is not installed.
        google.protobuf.message.DecodeError: ``model`` is no SentencePiece model.
    """
    from sentencepiece import sentencepiece_model_pb2

    proto = sentencepiece_model_pb2.ModelProto()
    proto.ParseFromString(model.read_bytes())
    vocabulary = [(piece.piece, piece.score) for piece in proto.pieces]
    tokenizer = Tokenizer(models.Unigram(vocabulary, proto.trainer_spec.unk_id, byte_fallback=False))
    steps = canonical()
    if proto.normalizer_spec.precompiled_charsmap:
        steps.append(normalizers.Precompiled(proto.normalizer_spec.precompiled_charsmap))
    tokenizer.normalizer = normalizers.Sequence(steps)
    tokenizer.pre_tokenizer = pre_tokenizers.Metaspace(prepend_scheme="always")
    number = [piece.piece for piece in proto.pieces].index(end)
    tokenizer.post_processor = processors.TemplateProcessing(single=f"$A {end}", special_tokens=[(end, number)])
    tokenizer.add_special_tokens([end])
    return tokenizer.to_str()


def canonical() -> list[normalizers.Normalizer]:
    """Lower case, without punctuation, single spaces: how SigLIP's training wrote its texts."""
    punctuation = "".join(f"\\{mark}" for mark in string.punctuation)
    return [
        normalizers.Lowercase(), normalizers.Replace(Regex(f"[{punctuation}]"), ""),
        normalizers.Replace(Regex(r"\s+"), " "), normalizers.Strip(),
    ]  # fmt: skip
