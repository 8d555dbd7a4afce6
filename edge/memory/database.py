"""The SQLite file of a home: its schema, and opening it safely."""

import fcntl
import io
import secrets
import shutil
import sqlite3
from pathlib import Path

import numpy as np

SCHEMA = 3
READABLE = ("1", "2", "3")  # 1 had no scans, 2 no tours and reaches
PER_NODE = 4  # most embeddings of one node; embedding.id = PER_NODE * node + region

# In SQLite's words, what keeps a whole store from being used.
_NOT_ITS_FAULT = "locked", "readonly", "full", "unable to open", "disk I/O"

_TABLES = """
CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT NOT NULL);  -- id: of this memory; mapped: whether to the end
CREATE TABLE node(id INTEGER PRIMARY KEY, stamp REAL NOT NULL, x REAL NOT NULL, y REAL NOT NULL, theta REAL NOT NULL,
    covariance BLOB NOT NULL, superseded_by INTEGER, keyframe BLOB, scan BLOB,
    tour INTEGER NOT NULL DEFAULT 0, reach BLOB);
CREATE TABLE embedding(id INTEGER PRIMARY KEY, bearing REAL NOT NULL, scale REAL NOT NULL, vector BLOB NOT NULL);
CREATE TABLE edge(id INTEGER PRIMARY KEY, i INTEGER NOT NULL, j INTEGER NOT NULL, dx REAL NOT NULL, dy REAL NOT NULL,
    dtheta REAL NOT NULL, information BLOB NOT NULL, kind TEXT NOT NULL);
CREATE TABLE map(id INTEGER PRIMARY KEY CHECK (id = 0), data BLOB NOT NULL);
"""


class StoreError(RuntimeError):
    """A store that cannot be used as asked; the message says what to do, and the file was left as it is."""


class EncoderMismatch(StoreError):
    """The store holds vectors of another encoder, which no text of this one can be compared with."""


def unusable(path, error):
    """The StoreError for what SQLite, or what reads its rows, said of the store at ``path``."""
    if any(word in str(error) for word in _NOT_ITS_FAULT):
        hint = "check that no other program uses it, that it may be written, and that the disk has room"
        return StoreError(f"{path} cannot be used ({error}); it was left as it is: {hint}")
    hint = "move it away to map anew, or restore a copy"
    return StoreError(f"{path} is not a readable VLPG store ({error}); it was left as it is: {hint}")


def lock_store(path):
    """An open file that keeps other robots from the store at ``path`` until it is closed, or the process ends.

    A file beside the store: to close any descriptor of the store itself would let go of SQLite's own locks.

    Raises:
        StoreError: another robot has the store open, or nothing can be written there.
    """
    if str(path) == ":memory:":
        return io.BytesIO()
    try:
        lock = open(f"{path}.lock", "wb")
    except OSError as error:
        hint = "check that its folder exists and is writable"
        raise StoreError(f"cannot open the store {path} ({error.strerror}); {hint}") from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        lock.close()
        raise StoreError(f"{path} is in use; stop the robot that uses it, or choose another file") from error
    return lock


def connect(path, encoder_name, encoder_digest, dim):
    """Opens or makes the store at ``path`` (``":memory:"`` for one that is never written) for one encoder.

    Returns an sqlite3 connection in autocommit mode, usable from one thread at a time.

    Raises:
        StoreError: not a store, damaged, of a newer schema, or not accessible. Nothing is written to such a file.
        EncoderMismatch: made with another encoder.
    """
    wanted = {"schema": str(SCHEMA), "encoder": encoder_name, "digest": encoder_digest, "dim": str(dim)}
    fresh = str(path) == ":memory:" or not Path(path).exists() or Path(path).stat().st_size == 0
    try:
        db = sqlite3.connect(str(path), isolation_level=None, check_same_thread=False, timeout=2.0)
    except sqlite3.Error as error:
        hint = "check that its folder exists and is writable"
        raise StoreError(f"cannot open the store {path} ({error}); {hint}") from error
    try:
        if fresh:
            # The page size of a file is fixed at its first write. A page holds seven 512-byte vectors.
            db.executescript("PRAGMA page_size=4096; PRAGMA journal_mode=WAL; BEGIN;" + _TABLES)
            db.executemany("INSERT INTO meta VALUES (?, ?)", (wanted | {"mapped": "0"}).items())
            db.execute("COMMIT")
        else:
            _check(db, path, wanted)
            _upgrade(db, Path(path))
            db.execute("PRAGMA journal_mode=WAL")
        db.execute("INSERT OR IGNORE INTO meta VALUES ('id', ?)", (secrets.token_hex(8),))
        # NORMAL: a power cut may lose the last commits, never the file. A small cache and a small log, because both
        # count against the budget of 1.5 (RAM) and 2.5 (disk) bytes per embedding byte.
        db.executescript("PRAGMA synchronous=NORMAL; PRAGMA cache_size=-256; PRAGMA wal_autocheckpoint=64;")
    except sqlite3.Error as error:
        db.close()
        raise unusable(path, error) from error
    except StoreError:
        db.close()
        raise
    return db


def _check(db, path, wanted):
    # quick_check reads every page (milliseconds for a home), so damage shows here and not in the middle of a mission.
    verdict = db.execute("PRAGMA quick_check(1)").fetchone()[0]
    if verdict != "ok":
        raise sqlite3.DatabaseError(verdict.splitlines()[-1])
    meta = dict(db.execute("SELECT key, value FROM meta"))
    if meta.get("schema") not in READABLE:
        raise StoreError(
            f"{path} has schema {meta.get('schema')}, and this version reads {' and '.join(READABLE)}; "
            "open it with the version that made it, or put back the older copy beside it, *.schema-N"
        )
    if any(meta.get(key) != wanted[key] for key in ("encoder", "digest", "dim")):
        raise EncoderMismatch(
            f"{path} holds vectors of the encoder {meta.get('encoder')} "
            f"({meta.get('digest', '')[:12]}, {meta.get('dim')}-d), "
            f"and this is {wanted['encoder']} ({wanted['digest'][:12]}, {wanted['dim']}-d); "
            f"run `vlpg reindex {path}` (on a board vlpg-reindex, as root), or choose the store's encoder"
        )


def _upgrade(db, path):
    """A store of an older schema to this one, in one transaction. The old one is kept: older versions read no other."""
    schema = int(db.execute("SELECT value FROM meta WHERE key='schema'").fetchone()[0])
    if schema == SCHEMA:
        return
    db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    try:
        shutil.copy2(path, path.with_name(f"{path.name}.schema-{schema}"))
    except OSError as error:
        raise StoreError(f"{path} cannot be brought up to date, as no copy can be kept ({error})") from error
    db.execute("BEGIN IMMEDIATE")
    if schema < 2:
        db.execute("ALTER TABLE node ADD COLUMN scan BLOB")
    db.execute("ALTER TABLE node ADD COLUMN tour INTEGER NOT NULL DEFAULT 0")
    db.execute("ALTER TABLE node ADD COLUMN reach BLOB")
    db.execute("UPDATE meta SET value=? WHERE key='schema'", (str(SCHEMA),))
    db.execute("COMMIT")


_UPPER = np.triu_indices(3)


def pack_symmetric(matrix):
    """A symmetric (3, 3) matrix as the 6 little-endian float64 of its upper triangle, row by row."""
    return np.asarray(matrix, "<f8")[_UPPER].tobytes()


def unpack_symmetric(blob):
    """The (3, 3) matrix that ``pack_symmetric`` wrote."""
    matrix = np.zeros((3, 3))
    matrix[_UPPER] = np.frombuffer(blob, "<f8")
    return matrix + np.triu(matrix, 1).T
