"""The image tower as ONNX: float32 export, static int8 trunk, int8 head, and the saliency graph."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import onnx
import torch
from onnxruntime.quantization import (
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_dynamic,
    quantize_static,
)
from onnxruntime.quantization.shape_inference import quant_pre_process

from tools.models.export import export_graph, save
from tools.models.quantization import Pictures
from tools.train.image_tower import DEEP, DETAIL, STRIDE, Front, Head, ImageTower, Saliency
from tools.train.int8_blocks import store_in_blocks

# The stem and the first block stay in float32: their few channels have such unequal ranges that with them in int8 the
# pooled features keep a median cosine of 0.977 to float32's, and 0.997 without. They are no slower in float32.
EXACT = 3  # convolutions


def round_weights(head: Head) -> None:
    """Put the head's matrices on an int8 grid (one scale an output row), in place.

    Both graphs then hold the same numbers exactly, and the saliency graph can be held to autograd on them.
    """
    with torch.no_grad():
        for matrix in (head.projection.weight, head.classifier.weight, head.concepts):
            scale = _scales(matrix)
            matrix.copy_(torch.round(matrix / scale) * scale)


def export_front(front: Front, height: int, width: int, path: Path) -> None:
    """``image`` (1, 3, H, W) to ``middle`` (1, 112, H/16, W/16) and ``logits`` (R, 1000)."""
    export_graph(front, (torch.zeros(1, 3, height, width),), path, ["image"], ["middle", "logits"])


def export_float(tower: ImageTower, height: int, width: int, path: Path) -> None:
    """``image`` (1, 3, H, W) to ``vectors`` (R, D) and the maps ``deep`` and ``detail``, opset 17."""
    export_graph(tower, (torch.zeros(1, 3, height, width),), path, ["image"], ["vectors", "deep", "detail"])


def export_saliency(head: Head, height: int, width: int, path: Path) -> None:
    """``deep``, ``detail`` and ``direction`` (D,) to ``map`` (2h, 2w); the head's matrices as int8 with scales."""
    h, w = height // STRIDE, width // STRIDE
    maps = torch.zeros(1, DEEP, h, w), torch.zeros(1, DETAIL, 2 * h, 2 * w)
    direction = torch.zeros(head.concepts.shape[1])
    export_graph(Saliency(head), (*maps, direction), path, ["deep", "detail", "direction"], ["map"])
    model = onnx.load(path)
    store_in_blocks(model.graph)
    save(model, path)


def quantize(source: Path, target: Path, pictures: Iterator[np.ndarray]) -> None:
    """Int8: convolutions static (QDQ, U8S8, per channel, min-max over ``pictures``), the head's Gemms dynamic."""
    ready, static = source.with_suffix(".ready.onnx"), source.with_suffix(".static.onnx")
    quant_pre_process(source, ready)
    convolutions = [node.name for node in onnx.load(ready).graph.node if node.op_type == "Conv"]
    quantize_static(
        ready,
        static,
        Pictures(pictures),
        quant_format=QuantFormat.QDQ,
        op_types_to_quantize=["Conv", "Clip", "Add"],
        per_channel=True,
        activation_type=QuantType.QUInt8,
        weight_type=QuantType.QInt8,
        calibrate_method=CalibrationMethod.MinMax,
        nodes_to_exclude=convolutions[:EXACT],
    )
    # The posterior is a few large and a thousand tiny shares: rounded to int8 the tiny ones vanish, so what multiplies
    # it (the only MatMul, the others are Gemm) stays in float32.
    concepts = [node.name for node in onnx.load(static).graph.node if node.op_type == "MatMul"]
    quantize_dynamic(
        static,
        target,
        op_types_to_quantize=["MatMul", "Gemm"],
        weight_type=QuantType.QInt8,
        per_channel=True,
        nodes_to_exclude=concepts,
    )
    save(onnx.load(target), target)


def _scales(matrix: torch.Tensor) -> torch.Tensor:
    return matrix.abs().amax(1, keepdim=True).clamp(min=1e-12) / 127
