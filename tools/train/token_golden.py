"""``python -m tools.train.token_golden``: what Hugging Face's tokenizers make of a thousand odd strings, kept small.

Needs transformers. The vocabulary is the text tower's, which is locked, so this is run again only when the strings
change. transformers has two BERT tokenizers: one in Python, which shares no code with ours and is the reference, and
one in Rust, which is ours with a configuration of its own. Where they disagree the strings are kept as disputed, with
the answer of the one in Rust: the tower was trained with that one, and it is what transformers gives by default.
"""

import json
import tempfile
import zlib
from pathlib import Path

import numpy as np

from models.manifest import Manifest, resolve
from tools.train.odd_strings import odd_strings

TARGET = Path("tests/edge/perception/tokens_golden.npz")


def reference(manifest: Manifest):
    """Both tokenizers of transformers, in Python and in Rust, as functions from a string to ids."""
    from transformers import BertTokenizer
    from transformers.models.bert.tokenization_bert_legacy import BertTokenizerLegacy

    vocabulary = json.loads((manifest.folder / manifest.text.tokenizer).read_text())["model"]["vocab"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "vocab.txt"
        file.write_text("".join(f"{word}\n" for word in sorted(vocabulary, key=vocabulary.get)), encoding="utf-8")
        python = BertTokenizerLegacy(str(file))
    rust = BertTokenizer(vocab=vocabulary, do_lower_case=True)
    cut = {"truncation": True, "max_length": manifest.text.context_length}
    # The one in Rust refuses halves of surrogate pairs, the one in Python leaves them out.
    whole = lambda text: text.encode("utf-8", "ignore").decode()  # noqa: E731
    return (
        lambda text: python(text, **cut)["input_ids"],
        lambda text: rust(whole(text), **cut)["input_ids"],
    )


def fingerprint(strings: list[str]) -> int:
    """A number that tells whether the strings are those of the golden file."""
    return zlib.crc32("\0".join(strings).encode("utf-8", "surrogatepass"))


def main() -> None:
    """Writes the golden file: ids end to end with their lengths, then those of the disputed strings."""
    strings = odd_strings()
    python, rust = reference(Manifest.load(resolve()))
    ids = [python(text) for text in strings]
    disputed = [i for i, text in enumerate(strings) if rust(text) != ids[i]]
    disputed_ids = [rust(strings[i]) for i in disputed]
    np.savez_compressed(
        TARGET,
        fingerprint=np.uint32(fingerprint(strings)),
        ids=np.concatenate(ids).astype(np.uint16),
        lengths=np.array([len(row) for row in ids], np.uint8),
        disputed=np.array(disputed, np.uint16),
        disputed_ids=np.concatenate(disputed_ids).astype(np.uint16),
        disputed_lengths=np.array([len(row) for row in disputed_ids], np.uint8),
    )
    print(f"{TARGET}: {len(strings)} strings, of which {len(disputed)} are disputed; {TARGET.stat().st_size} bytes")


if __name__ == "__main__":
    main()
