"""PyTorch modules as float32 ONNX graphs, opset 17."""

import warnings
from pathlib import Path

import onnx
import torch
from torch import nn

OPSET = 17


def export_graph(module: nn.Module, arguments, path: Path, inputs: list[str], outputs: list[str], dynamic=None) -> None:
    """Trace ``module`` on ``arguments``; ``dynamic`` maps names to the axes, {number: name}, that may vary."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fast = torch.backends.mha.get_fastpath_enabled()
    torch.backends.mha.set_fastpath_enabled(False)  # its fused operator has no ONNX form
    try:
        with warnings.catch_warnings():
            # On every shape that becomes a constant, as shapes here are meant to.
            warnings.simplefilter("ignore")
            torch.onnx.export(
                module.eval(), arguments, str(path), input_names=inputs, output_names=outputs, dynamic_axes=dynamic,
                opset_version=OPSET, dynamo=False,
            )  # fmt: skip
    finally:
        torch.backends.mha.set_fastpath_enabled(fast)


def export_text(text: nn.Module, ids: torch.Tensor, path: Path, fixed: bool) -> None:
    """``input_ids`` (1, T) int64 to ``embedding`` (1, D).

    T varies unless it is ``fixed`` to that of ``ids``.
    """
    dynamic = None if fixed else {"input_ids": {1: "length"}}
    export_graph(text, (ids,), path, ["input_ids"], ["embedding"], dynamic)


def save(model: onnx.ModelProto, path: Path) -> None:
    """With its weights in ``<name>.data`` beside it, which the runtime maps instead of reading."""
    data = path.name + ".data"
    path.with_name(data).unlink(missing_ok=True)
    onnx.save(model, path, save_as_external_data=True, location=data, size_threshold=1024)
