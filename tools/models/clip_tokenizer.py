"""CLIP's byte-pair encoding, as OpenCLIP has it, in the form that the robot's tokenizer reads."""

import json

# CLIP's words: specials, English clitics, letters, single digits, runs of anything else but spaces.
_WORDS = r"{start}|{end}|'s|'t|'re|'ve|'m|'ll|'d|[\p{{L}}]+|[\p{{N}}]|[^\s\p{{L}}\p{{N}}]+"
# What ftfy, which OpenCLIP runs first, does to ligatures, wide letters and curly quotes. Its repair of wrongly decoded
# text and of HTML entities is left out: prompts are typed, not scraped.
_LIGATURES = {
    "Ĳ": "IJ", "ĳ": "ij", "ŉ": "'n", "Ǆ": "DŽ", "ǅ": "Dž", "ǆ": "dž", "Ǉ": "LJ", "ǈ": "Lj", "ǉ": "lj", "Ǌ": "NJ",
    "ǋ": "Nj", "ǌ": "nj", "Ǳ": "DZ", "ǲ": "Dz", "ǳ": "dz", "ﬀ": "ff", "ﬁ": "fi", "ﬂ": "fl", "ﬃ": "ffi", "ﬄ": "ffl",
    "ﬅ": "ſt", "ﬆ": "st",
}  # fmt: skip
_WIDE = {chr(0xFEE0 + code): chr(code) for code in range(0x21, 0x7F)}
_QUOTES = {quote: "'" for quote in "‘’‚‛ʼ"} | {quote: '"' for quote in "“”„‟"}


def tokenizer_json(encoder: dict[str, int], merges: list[tuple[str, str]], start: str, end: str) -> str:
    """A ``tokenizers`` file from the vocabulary (token to id), the merges in order, and the special tokens' texts.

    Prompts are put between ``start`` and ``end``; one that is cut still ends in ``end``.
    """
    from tokenizers import Regex, Tokenizer, models, normalizers, pre_tokenizers, processors

    tokenizer = Tokenizer(models.BPE(encoder, merges, unk_token=end, end_of_word_suffix="</w>"))
    repairs = [normalizers.Replace(odd, plain) for odd, plain in (_LIGATURES | _WIDE | _QUOTES).items()]
    spaces = normalizers.Replace(Regex(r"\s+"), " ")
    tokenizer.normalizer = normalizers.Sequence([normalizers.NFC(), *repairs, spaces, normalizers.Lowercase()])
    words = Regex(_WORDS.format(start=start.replace("|", r"\|"), end=end.replace("|", r"\|")))
    tokenizer.pre_tokenizer = pre_tokenizers.Sequence(
        [
            pre_tokenizers.Split(words, "removed", invert=True),
            pre_tokenizers.ByteLevel(add_prefix_space=False, use_regex=False),
        ]
    )
    tokenizer.post_processor = processors.TemplateProcessing(
        single=f"{start} $A {end}", special_tokens=[(start, encoder[start]), (end, encoder[end])]
    )
    tokenizer.add_special_tokens([start, end])
    return json.dumps(json.loads(tokenizer.to_str()), ensure_ascii=False)


def from_open_clip(tokenizer) -> str:
    """The ``tokenizers`` file of an ``open_clip.SimpleTokenizer``."""
    ranked = sorted(tokenizer.bpe_ranks, key=tokenizer.bpe_ranks.get)
    words = {number: token for token, number in tokenizer.encoder.items()}
    start, end = words[tokenizer.sot_token_id], words[tokenizer.eot_token_id]
    return tokenizer_json(tokenizer.encoder, ranked, start, end)
