"""With the import extra only."""

import pickle

import pytest

pytest.importorskip("safetensors")
pytest.importorskip("onnx")

from models.manifest import ModelError  # noqa: E402
from tools.models.loading import loading  # noqa: E402


@pytest.mark.parametrize("error", [RuntimeError, OSError, KeyError, pickle.UnpicklingError])
def test_a_frameworks_error_is_one_sentence(error):
    with pytest.raises(ModelError, match="^a toy cannot be exported: ('first|first)"), loading("a toy", "exported"):
        raise error("first\nsecond")


def test_what_is_explained_already_stays():
    with pytest.raises(ModelError, match="^as it is$"), loading("a toy"):
        raise ModelError("as it is")
    with pytest.raises(ModuleNotFoundError), loading("a toy"):
        raise ModuleNotFoundError("torch")


def test_a_fault_of_ours_is_no_mistake_of_the_users():
    with pytest.raises(ZeroDivisionError), loading("a toy"):
        raise ZeroDivisionError
