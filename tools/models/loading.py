"""Models of other frameworks are loaded and traced by those frameworks; what they make of it is told in a sentence."""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager

from google.protobuf.message import DecodeError
from onnx.checker import ValidationError
from onnxruntime.capi import onnxruntime_pybind11_state as runtime
from safetensors import SafetensorError

from models.manifest import ModelError

_MISTAKES = (
    RuntimeError, OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, ImportError,
    pickle.UnpicklingError, SafetensorError, DecodeError, ValidationError, runtime.Fail, runtime.InvalidArgument,
    runtime.InvalidGraph, runtime.InvalidProtobuf, runtime.NoSuchFile, runtime.NotImplemented, runtime.RuntimeException,
)  # fmt: skip


@contextmanager
def loading(source: str, done: str = "loaded") -> Iterator[None]:
    """Turns the errors of a framework, while ``source`` is being ``done``, into ModelErrors."""
    try:
        yield
    except (ModelError, ModuleNotFoundError):
        raise
    except _MISTAKES as error:
        first = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise ModelError(f"{source} cannot be {done}: {first}") from None
