"""What prompts mean to one encoder, remembered: a prompt that was encoded once needs no text tower again."""

import hashlib
import sqlite3
import zlib
from collections import OrderedDict
from contextlib import suppress
from pathlib import Path

import numpy as np

_LAYOUT = 1  # of the table below; a file of another layout is thrown away
_TABLE = """
CREATE TABLE prompt(key BLOB PRIMARY KEY, used INTEGER NOT NULL, vector BLOB NOT NULL, checksum INTEGER NOT NULL);
CREATE INDEX prompt_used ON prompt(used);
"""
# SQLite's primary result codes that say that the file itself is bad: CORRUPT, NOTADB, CONSTRAINT, MISMATCH, TOOBIG,
# ERROR (no such table). All others (busy, read-only, no space) will pass or are the machine's.
_DAMAGED = frozenset({11, 26, 19, 20, 18, 1})


class PromptMemory:
    """Vectors by encoder and prompt: the latest in RAM, many in one SQLite file that all processes of a user share.

    It is only ever a shortcut. A file that cannot be opened or written is done without, one that is damaged is thrown
    away, and a vector that is not exactly what was put in is encoded again. Prompts are kept as
    hashes, for keys of one length, not for secrecy: whoever guesses a household noun can look it up.
    """

    IN_RAM = 256  # prompts; 0.4 MB at 384 dimensions
    ON_DISK = 2000  # prompts of all encoders; 5 MB at 384 dimensions, and years of a household's questions
    PATIENCE = 0.2  # s to wait for another process that writes; then this one does without

    def __init__(self, encode, digest: str, dim: int, path: Path | None = None):
        """``encode(texts) -> (N, dim)`` is asked for what is not known, of the encoder that ``digest`` names.

        ``path``: the file, made on first use with its folder; None remembers in RAM only. Use from one thread at a
        time.
        """
        self._encode, self._digest, self._dim = encode, digest, dim
        self._path = path
        self._latest: OrderedDict[str, np.ndarray] = OrderedDict()
        self._db: sqlite3.Connection | None = None

    def encode(self, texts: list[str]) -> np.ndarray:
        """``(N, dim)`` float32 rows. Whatever ``encode`` raises for unknown prompts passes through."""
        found = {text: vector for text in dict.fromkeys(texts) if (vector := self._recall(text)) is not None}
        unknown = [text for text in dict.fromkeys(texts) if text not in found]
        if unknown:
            vectors = np.array(self._encode(unknown), np.float32)
            found.update(zip(unknown, vectors, strict=True))
            self._save(unknown, vectors)
        for text, vector in found.items():
            self._latest[text] = vector
            self._latest.move_to_end(text)
        while len(self._latest) > self.IN_RAM:
            self._latest.popitem(last=False)
        return np.stack([found[text] for text in texts]) if texts else np.zeros((0, self._dim), np.float32)

    def close(self) -> None:
        """Close the file. It is opened again when it is needed again."""
        if self._db is not None:
            with suppress(sqlite3.Error):
                self._db.close()
        self._db = None

    def _recall(self, text: str) -> np.ndarray | None:
        if text in self._latest:
            return self._latest[text]
        key = self._key(text)
        row = self._try(lambda db: db.execute("SELECT vector, checksum FROM prompt WHERE key = ?", (key,)).fetchone())
        if row is None or not isinstance(row[0], bytes) or row[1] != _checksum(key, row[0]):
            return None
        self._try(lambda db: db.execute("UPDATE prompt SET used = ? WHERE key = ?", (_now(db), key)))
        return np.frombuffer(row[0], np.float32)

    def _save(self, texts: list[str], vectors: np.ndarray) -> None:
        keys = [self._key(text) for text in texts]
        blobs = [vector.tobytes() for vector in vectors]
        rows = [(key, blob, _checksum(key, blob)) for key, blob in zip(keys, blobs)]

        def save(db):
            with db:
                db.execute("BEGIN IMMEDIATE")
                now = _now(db)
                db.executemany(
                    "INSERT OR REPLACE INTO prompt(key, used, vector, checksum) VALUES (?, ?, ?, ?)",
                    [(key, now, blob, checksum) for key, blob, checksum in rows],
                )
                db.execute(
                    "DELETE FROM prompt WHERE rowid IN (SELECT rowid FROM prompt ORDER BY used DESC LIMIT -1 OFFSET ?)",
                    (self.ON_DISK,),
                )

        self._try(save)

    def _key(self, text: str) -> bytes:
        # A lone surrogate (half an emoji) is valid in a Python string but has no UTF-8 form of its own.
        return hashlib.sha256(f"{self._digest} {self._dim} {text}".encode("utf-8", "surrogatepass")).digest()

    def _try(self, action):
        """``action(db)``, or None when the file does not allow it. A damaged file is thrown away, and tried anew."""
        for _ in range(2):
            if self._path is None:
                return None
            try:
                if self._db is None:
                    self._db = _opened(self._path, self.PATIENCE)
                return action(self._db)
            except OSError:  # no such folder, or not ours
                self._path = None
            except sqlite3.Error as error:
                if (getattr(error, "sqlite_errorcode", 1) & 0xFF) not in _DAMAGED:
                    return None
                self.close()
                self._throw_away()
        self._path = None
        return None

    def _throw_away(self) -> None:
        # The log first: left behind, it would be played into the new file.
        for ending in ("-wal", "-shm", ""):
            try:
                Path(f"{self._path}{ending}").unlink(missing_ok=True)
            except OSError:
                self._path = None
                return


def _opened(path: Path, patience: float) -> sqlite3.Connection:
    """Raises sqlite3.Error or OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    db = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=patience)
    try:
        # NORMAL: a power cut may lose the last prompts, never the file. Small cache and log, as of a home's store.
        db.executescript(
            "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA cache_size=-128; PRAGMA wal_autocheckpoint=64;"
        )
        if _layout(db) == 0:
            db.execute("BEGIN IMMEDIATE")
            if _layout(db) == 0:  # no other process has made it meanwhile
                for statement in _TABLE.split(";"):
                    db.execute(statement)
                db.execute(f"PRAGMA user_version={_LAYOUT}")
            db.execute("COMMIT")
        if _layout(db) != _LAYOUT:
            raise sqlite3.DatabaseError("another layout")
    except sqlite3.Error:
        db.close()
        raise
    return db


def _layout(db: sqlite3.Connection) -> int:
    return db.execute("PRAGMA user_version").fetchone()[0]


def _now(db: sqlite3.Connection) -> int:
    """The order of use, without a clock: one more than the latest."""
    return db.execute("SELECT coalesce(max(used), 0) + 1 FROM prompt").fetchone()[0]


def _checksum(key: bytes, vector: bytes) -> int:
    return zlib.crc32(vector, zlib.crc32(key))
