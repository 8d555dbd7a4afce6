import os
import sqlite3
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from edge.memory.prompts import PromptMemory

DIM = 6


class Tower:
    """A vector for each text that nothing else has, and a record of what was asked."""

    def __init__(self, seed=0):
        self.seed, self.asked = seed, []

    def encode(self, texts):
        self.asked += texts
        return np.stack([self.vector(text) for text in texts])

    def vector(self, text):
        return np.random.default_rng([self.seed, *map(ord, text)]).normal(size=DIM).astype(np.float32)


def memory(path=None, tower=None, digest="ab" * 32):
    return PromptMemory((tower or Tower()).encode, digest, DIM, path)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cache" / "prompts.db"  # its folder is not there yet


def rows(path):
    with sqlite3.connect(path) as db:
        return db.execute("SELECT count(*) FROM prompt").fetchone()[0]


texts = st.lists(st.text(st.characters(codec=None), max_size=8), max_size=6)  # lone surrogates included


@given(st.lists(texts, max_size=6))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_nobody_can_tell_it_from_the_tower(tmp_path_factory, questions):
    """Any questions, in any order, each from a memory of its own on the same file."""
    path, tower, asked = tmp_path_factory.mktemp("any") / "prompts.db", Tower(), set()
    for question in questions:
        tower.asked = []
        remembering = memory(path, tower)
        expected = np.array([tower.vector(text) for text in question], np.float32).reshape(-1, DIM)
        np.testing.assert_array_equal(remembering.encode(question), expected)
        assert sorted(tower.asked) == sorted(set(question) - asked)  # each prompt costs one run, ever
        asked |= set(question)
        remembering.close()


@given(st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=40))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damage_anywhere_is_never_an_error_nor_a_wrong_vector(tmp_path_factory, damage):
    path, prompts = tmp_path_factory.mktemp("any") / "prompts.db", [f"a photo of {n}" for n in range(20)]
    first = memory(path)
    expected = first.encode(prompts)
    first.close()
    content = bytearray(path.read_bytes())
    for place, value in damage:
        content[int(place * len(content))] = value
    path.write_bytes(content)
    for _ in range(2):
        after = memory(path)
        np.testing.assert_array_equal(after.encode(prompts), expected)
        after.close()


@pytest.mark.parametrize("content", [b"", b"no database at all" * 300, b"SQLite format 3\0" + bytes(4080)])
def test_a_file_that_is_no_memory_becomes_one(path, content):
    path.parent.mkdir()
    path.write_bytes(content)
    tower = Tower()
    for _ in range(2):
        remembering = memory(path, tower)
        remembering.encode(["a cup"])
        remembering.close()
    assert tower.asked == ["a cup"] and rows(path) == 1


def test_a_file_of_another_layout_is_thrown_away(path):
    path.parent.mkdir()
    with sqlite3.connect(path) as db:
        db.executescript("PRAGMA user_version=77; CREATE TABLE prompt(nonsense)")
    memory(path).encode(["a cup"])
    assert rows(path) == 1


def test_it_is_damaged_while_in_use(path):
    tower = Tower()
    remembering = memory(path, tower)
    remembering.encode([f"{n}" for n in range(300)])
    with sqlite3.connect(path) as db:
        db.execute("DROP TABLE prompt")
    for question in (["a cup"], ["a cup", "0"]):
        np.testing.assert_array_equal(remembering.encode(question), [tower.vector(text) for text in question])
    assert rows(path) == 2


def test_two_encoders_never_answer_for_each_other(path):
    ours, theirs = Tower(1), Tower(2)
    memory(path, ours, "ab" * 32).encode(["a cup"])
    np.testing.assert_array_equal(memory(path, theirs, "cd" * 32).encode(["a cup"]), [theirs.vector("a cup")])
    assert rows(path) == 2


def test_the_least_recently_used_go(path, monkeypatch):
    monkeypatch.setattr(PromptMemory, "ON_DISK", 5)
    memory(path).encode(list("abcde"))
    memory(path).encode(["b"])
    memory(path).encode(list("fgh"))
    tower = Tower()
    memory(path, tower).encode(["b"])
    assert rows(path) == 5 and tower.asked == []


def test_the_file_and_the_ram_are_bounded(path):
    remembering = memory(path)
    for start in range(0, 3000, 500):
        remembering.encode([f"{n} bottles" for n in range(start, start + 500)])
    assert len(remembering._latest) == PromptMemory.IN_RAM
    remembering.close()
    assert rows(path) == PromptMemory.ON_DISK


def test_a_question_longer_than_the_ram_holds(path):
    many = [f"{n}" for n in range(PromptMemory.IN_RAM + 50)]
    np.testing.assert_array_equal(memory().encode(many), [Tower().vector(text) for text in many])


@pytest.mark.parametrize("blocked", ["folder", "file", "read-only"])
def test_where_nothing_can_be_written_it_does_without(tmp_path, blocked):
    path = tmp_path / "cache" / "prompts.db"
    if blocked == "folder":
        (tmp_path / "cache").write_text("a file where the folder should be")
    elif blocked == "file":
        path.mkdir(parents=True)
    else:
        memory(path).encode(["another"])
        path.parent.chmod(0o500)
        path.chmod(0o400)
    tower = Tower()
    remembering = memory(path, tower)
    for _ in range(2):
        np.testing.assert_array_equal(remembering.encode(["a cup"]), [tower.vector("a cup")])
    assert tower.asked == ["a cup"]  # still remembered in RAM
    path.parent.chmod(0o700)


def test_a_file_that_somebody_holds_is_not_waited_for_long(path, monkeypatch):
    monkeypatch.setattr(PromptMemory, "PATIENCE", 0.05)
    memory(path).encode(["a cup"])
    tower = Tower()
    with sqlite3.connect(path, isolation_level=None) as holder:
        holder.execute("BEGIN IMMEDIATE")
        other = memory(path, tower)
        other.encode(["a cup", "a mug"])
        holder.execute("ROLLBACK")
    assert tower.asked == ["a mug"]  # reading goes on beside a writer
    assert rows(path) == 1
    other.encode(["a jug"])
    assert rows(path) == 2


def test_what_the_tower_raises_passes_and_nothing_is_remembered(path):
    def gone(texts):
        raise ConnectionError("no host")

    remembering = PromptMemory(gone, "ab" * 32, DIM, path)
    with pytest.raises(ConnectionError):
        remembering.encode(["a cup"])
    tower = Tower()
    memory(path, tower).encode(["a cup"])
    assert tower.asked == ["a cup"]


def test_prompts_cannot_be_read_in_the_file(path):
    memory(path).encode(["my secret diary"])
    assert all(b"secret" not in file.read_bytes() for file in path.parent.iterdir())


_WORKER = """
import sys
from pathlib import Path
from tests.edge.memory.test_prompts import DIM, Tower, memory
import numpy as np
tower = Tower()
for round in range(15):
    remembering = memory(Path(sys.argv[1]), tower)
    question = [f"{n}" for n in range(round, round + 40)]
    np.testing.assert_array_equal(remembering.encode(question), [tower.vector(text) for text in question])
    if sys.argv[2] == "destroy" and round % 5 == 4:
        Path(sys.argv[1]).write_bytes(b"damaged by a power cut" * 1000)
"""


@pytest.mark.timeout(60)
@pytest.mark.parametrize("second", ["write", "destroy"])
def test_two_processes_at_once(path, second):
    command = [sys.executable, "-W", "error", "-c", _WORKER, str(path)]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    workers = [
        subprocess.Popen([*command, how], stderr=subprocess.PIPE, text=True, env=environment)
        for how in ("write", second)
    ]
    for worker in workers:
        _, complaints = worker.communicate(timeout=50)
        assert worker.returncode == 0, complaints
    memory(path).encode(["a cup"])
    assert 1 <= rows(path) <= 56
