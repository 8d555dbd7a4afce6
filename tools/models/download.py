"""One file over HTTP: resumed where an earlier attempt ended, and checked before it gets its name."""

import http.client
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path

from models.manifest import File, ModelError, sha256

TIMEOUT = 30.0  # s without a byte
TRIES = 4  # connections that may break, for one file
_BLOCK = 1 << 18  # bytes between two reports of progress


class Missing(ModelError):
    """The server answers, but does not have the file."""


class Shorter(ModelError):
    """The server's file ends before the byte at which to go on."""


class Broken(ModelError):
    """The connection ended before the file did; what came is kept."""


def read(url: str, token: str | None = None, limit: int = 1 << 20) -> bytes:
    """All of a small file, at most ``limit`` bytes.

    Raises:
        ModelError: unreachable (Missing: not there), or larger.
    """
    with _open(url, token, 0) as answer:
        try:
            content = answer.read(limit + 1)
        except (OSError, http.client.HTTPException) as error:
            raise _broken(url, error) from None
    if len(content) > limit:
        raise ModelError(f"{url} is larger than {limit} bytes; that is not a model's description.")
    return content


def download(
    url: str, folder: Path, file: File, token: str | None = None, progress: Callable[[int], None] = lambda size: None
) -> None:
    """Put ``file`` from ``url`` into ``folder``; ``progress`` is told how many bytes of it are there so far.

    What comes is kept in ``<name>.part`` until it is whole: a connection that breaks is resumed, here up to ``TRIES``
    times and by the next call, if the server knows ranges.

    Raises:
        ModelError: unreachable, or not the file that was expected.
    """
    target, part = folder / file.name, folder / f"{file.name}.part"
    if target.is_file() and target.stat().st_size == file.size and sha256(target) == file.sha256:
        progress(file.size)
        return
    for rest in reversed(range(TRIES)):
        try:
            _append(url, part, file.size, token, progress)
            break
        except Shorter:
            raise _changed(url, part) from None
        except Broken:
            if not rest:
                raise
    if part.stat().st_size != file.size or sha256(part) != file.sha256:
        raise _changed(url, part)
    part.rename(target)


def _append(url: str, part: Path, size: int, token: str | None, progress: Callable[[int], None]) -> None:
    """Everything of ``url`` after the bytes that ``part`` has, up to one byte more than ``size``."""
    there = part.stat().st_size if part.exists() else 0
    if there > size:
        there = 0
    elif there == size and part.exists():
        return
    with _open(url, token, there) as answer:
        resumed = answer.status == http.client.PARTIAL_CONTENT
        there = there if resumed else 0
        if answer.length is not None and there + answer.length != size:
            raise _changed(url, part)
        with part.open("ab" if resumed else "wb") as stream:
            while there <= size:
                try:
                    block = answer.read(min(_BLOCK, size + 1 - there))
                except (OSError, http.client.HTTPException) as error:
                    raise _broken(url, error) from None
                if not block:
                    break
                stream.write(block)
                there += len(block)
                progress(min(there, size))
    if there < size:
        raise _broken(url, f"{there} of {size} bytes came")


def _open(url: str, token: str | None, start: int):
    try:
        request = urllib.request.Request(url, headers={"User-Agent": "vlpg"})
        if start:
            request.add_header("Range", f"bytes={start}-")
        if token:
            # Not for whom the hub may redirect to: storage elsewhere has no use for it.
            request.add_unredirected_header("Authorization", f"Bearer {token}")
        return urllib.request.urlopen(request, timeout=TIMEOUT)
    except urllib.error.HTTPError as error:
        error.close()
        if error.code == http.client.NOT_FOUND:
            raise Missing(f"There is no {url}.") from None
        if error.code == http.client.REQUESTED_RANGE_NOT_SATISFIABLE:
            raise Shorter(f"{url} ends before byte {start}.") from None
        if error.code in (http.client.UNAUTHORIZED, http.client.FORBIDDEN):
            raise ModelError(f"{url} may not be read ({error.code}); if it is private, set HF_TOKEN.") from None
        raise ModelError(f"{url} cannot be read: the server answers {error.code} {error.reason}.") from None
    except (OSError, http.client.HTTPException, ValueError) as error:  # OSError includes URLError
        reason = getattr(error, "reason", error)
        raise ModelError(f"{url} cannot be reached ({reason}); check the network, or HF_ENDPOINT.") from None


def _changed(url: str, part: Path) -> ModelError:
    part.unlink(missing_ok=True)
    return ModelError(f"{url} is damaged or was changed: its size or sha256 is not the manifest's; try again later.")


def _broken(url: str, why) -> Broken:
    return Broken(f"The connection to {url} broke ({why}); run the command again, it goes on from there.")
