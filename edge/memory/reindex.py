"""Moves a store to another encoder: the poses, edges and map stay, the kept pictures are looked at again."""

import os
import shutil
import sqlite3
from pathlib import Path
from typing import NamedTuple

from edge.camera import CameraModel
from edge.memory.database import PER_NODE, READABLE, StoreError, connect, lock_store, unusable
from edge.memory.vectors import quantize

# Writes all of the log into the file and fails where anybody else has it open: what they have not written yet would be
# lost, or their log be read into the new file.
_ALONE = "PRAGMA old.journal_mode=DELETE"
_WITHDRAW = "UPDATE main.node SET superseded_by = id WHERE"


class Reindexed(NamedTuple):
    """What became of the nodes that answered queries."""

    embedded: int  # have vectors of the new encoder
    withdrawn: int  # had no picture that can be read, so they answer no more; they stay for audit


def reindex(path, encoder_name, encoder_digest, dim, embed):
    """Rewrites the store at ``path`` for another encoder; the old file stays beside it as ``<path>.before-reindex``.

    ``embed(jpeg, hfov) -> (vectors (R, dim), bearings (R,))`` looks at one kept picture, of a camera with ``hfov``
    [rad]; None when it cannot be read. The store is replaced at the very end and at once, so whatever goes wrong
    before, it is as it was.

    Raises StoreError when ``path`` is not a readable store, a robot uses it, or no node of it kept its picture.
    """
    path = Path(path)
    if not path.is_file():
        raise StoreError(f"there is no store at {path}")
    with lock_store(path) as lock:
        kept = path.stat()
        os.fchown(lock.fileno(), kept.st_uid, kept.st_gid)  # on a board, root does this for the robot's own user
        return _reindex(path, encoder_name, encoder_digest, dim, embed)


def _reindex(path, encoder_name, encoder_digest, dim, embed):
    fresh = path.with_name(path.name + ".reindexing")
    fresh.unlink(missing_ok=True)
    db = connect(fresh, encoder_name, encoder_digest, dim)
    result = None
    try:
        result = _copy(db, path, embed)
    except sqlite3.Error as error:
        raise unusable(path, error) from error
    finally:
        db.close()
        if result is None:
            fresh.unlink()
    copy = path.with_name(path.name + ".copying")
    try:
        kept = path.stat()
        os.chown(fresh, kept.st_uid, kept.st_gid)
        fresh.chmod(kept.st_mode)
        shutil.copy2(path, copy)
        os.replace(copy, path.with_name(path.name + ".before-reindex"))  # there is a store at path at any time
        os.replace(fresh, path)
    except OSError as error:
        fresh.unlink(missing_ok=True)
        copy.unlink(missing_ok=True)
        raise StoreError(f"{path} cannot be replaced ({error}); it was left as it is") from error
    return result


def _copy(db, path, embed):
    db.execute("ATTACH DATABASE ? AS old", (str(path),))
    db.execute(_ALONE)
    meta = dict(db.execute("SELECT key, value FROM old.meta"))
    schema = meta.get("schema")
    if schema not in READABLE:
        raise StoreError(f"{path} has schema {schema}, and this version reads {' and '.join(READABLE)}")
    try:
        hfov = float(meta.get("hfov", CameraModel.hfov))
    except ValueError as error:
        raise StoreError(f"{path} is damaged: its camera's field of view is no number ({error})") from error
    answering = "FROM old.node WHERE superseded_by IS NULL AND keyframe IS NOT NULL"
    if db.execute(f"SELECT count(*) {answering}").fetchone()[0] == 0:
        raise StoreError(f"{path} kept no pictures to look at again; move it away and map the home anew")
    db.execute("BEGIN")
    for table in ("node", "edge", "map"):
        columns = ", ".join(row[1] for row in db.execute(f"PRAGMA old.table_info({table})"))
        db.execute(f"INSERT INTO main.{table}({columns}) SELECT {columns} FROM old.{table}")
    db.execute("DELETE FROM main.meta WHERE key = 'mapped'")
    db.execute("INSERT INTO main.meta SELECT * FROM old.meta WHERE key IN ('mapped', 'hfov')")
    withdrawn = db.execute(f"{_WITHDRAW} superseded_by IS NULL AND keyframe IS NULL").rowcount
    embedded = 0
    for node, jpeg in db.execute(f"SELECT id, keyframe {answering} ORDER BY id"):
        seen = embed(jpeg, hfov)
        if seen is None:
            withdrawn += db.execute(f"{_WITHDRAW} id = ?", (node,)).rowcount
            continue
        vectors, bearings = seen
        matrix, scales = quantize(vectors)
        db.executemany(
            "INSERT INTO main.embedding VALUES (?, ?, ?, ?)",
            [
                (PER_NODE * node + region, float(bearings[region]), float(scales[region]), row.tobytes())
                for region, row in enumerate(matrix)
            ],
        )
        embedded += 1
    if not embedded:
        raise StoreError(f"none of the pictures that {path} kept can be read; move it away and map the home anew")
    db.execute("COMMIT")
    db.execute(_ALONE)
    db.execute("DETACH DATABASE old")
    return Reindexed(embedded, withdrawn)
