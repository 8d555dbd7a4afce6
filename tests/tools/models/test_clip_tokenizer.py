"""With the import extra only: the robot's tokenizer gives OpenCLIP's own ids."""

import pytest

open_clip = pytest.importorskip("open_clip")

from tokenizers import Tokenizer  # noqa: E402

from tools.models.clip_tokenizer import from_open_clip  # noqa: E402

ODD = [
    "", " ", "\t\n", "a photo of a teddy bear", "A PHOTO of the Éclair", "it's they're I'd we'll DON'T",
    "42 chairs, 3.14!",
    "\U0001f9f8 a bear \U0001f468\u200d\U0001f469\u200d\U0001f467", "\U0001fa91" * 3, "椅子", "стул у окна", "كرسي",
    "कुर्सी", "ザブトン", "a\u0301 e\u0301", "x" * 5000, "very long " * 300, "wall-mounted_tv #1 (left) & right",
    "İstanbul",
    "“curly” ‘quotes’", "ﬁlter coﬀee", "ß Ĳ ŉ ǅ ǆ ﬆ", "<start_of_text>", "a <end_of_text> b", "\\ / | ~ ^ `", "½ ² Ⅷ",
    "\u200bzero\u200bwidth", "ＡＢＣ　ｔｖ！",
]  # fmt: skip


@pytest.fixture(scope="module")
def theirs():
    return open_clip.SimpleTokenizer()


@pytest.fixture(scope="module")
def ours(theirs):
    tokenizer = Tokenizer.from_str(from_open_clip(theirs))
    tokenizer.enable_truncation(theirs.context_length)
    return tokenizer


@pytest.mark.parametrize("text", ODD)
def test_the_ids_are_open_clips(ours, theirs, text):
    ids = ours.encode(text).ids
    assert ids + [0] * (77 - len(ids)) == theirs([text])[0].tolist()


def test_a_prompt_that_is_cut_ends_in_the_end_token(ours, theirs):
    ids = ours.encode("a chair and a table " * 100).ids
    assert len(ids) == 77 and ids[-1] == theirs.eot_token_id
