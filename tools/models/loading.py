"""Weights of other frameworks are loaded by those frameworks; what they make of a bad file is told in a sentence."""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager

from google.protobuf.message import DecodeError
from safetensors import SafetensorError

from models.manifest import ModelError

_MISTAKES = (
    RuntimeError, OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, ImportError,
    pickle.UnpicklingError, SafetensorError, DecodeError,
)  # fmt: skip


@contextmanager
def loading(source: str) -> Iterator[None]:
    """Turns the errors of a framework that loads ``source`` into ModelErrors."""
    try:
        yield
    except (ModelError, ModuleNotFoundError):
        raise
    except _MISTAKES as error:
        first = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise ModelError(f"{source} cannot be loaded: {first}") from None
