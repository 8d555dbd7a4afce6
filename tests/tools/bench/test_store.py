import json
from collections import Counter

import pytest

from tools.bench import search, store


@pytest.mark.parametrize(("kind", "exchanged"), [("vlpg", 1), ("faiss", 0), ("usearch", 8)])  # by rounding to int8
def test_every_exact_search_finds_what_numpy_finds(kind, exchanged):
    if kind != "vlpg":
        pytest.importorskip(kind)
    query = search.unit_vectors(1, 3)[0]
    best, _ = search.numpy(400)(query)
    found = search.KINDS[kind](400)(query)
    rows = {"vlpg": lambda: found.ids, "faiss": lambda: found[1][0], "usearch": lambda: found.keys}[kind]()
    wanted = best // search.REGIONS if kind == "vlpg" else best
    assert (Counter(wanted.tolist()) & Counter(rows.tolist())).total() >= search.HITS - exchanged


def test_searches_are_timed_and_the_memory_weighed(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(store, "PEERS", {"float32, exact, numpy": ("numpy", "numpy"), "magic": ("magic", "magic")})
    store.main(["--vectors", "400", "--turns", "3", "--json", str(tmp_path / "store.json")])
    printed = capsys.readouterr().out
    assert store.OURS in printed and "1.00x" in printed and "magic is left out" in printed
    ours, peer = json.loads((tmp_path / "store.json").read_text())["400"]
    assert ours["ratio"] == 1 and peer["name"] == "float32, exact, numpy" and peer["p50"] > 0
    assert 1 < store.bytes_per_byte(400) < 1.5


@pytest.mark.parametrize(
    ("arguments", "words"), [(["--vectors", "3"], "at least 50"), (["--vectors", "x"], "x"), (["--turns", "0"], "1")]
)
def test_a_mistake_is_told_in_a_sentence(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        store.main(arguments)
    assert ended.value.code == 2 and words in capsys.readouterr().err
