"""Int8 versions of a tower's float32 graph, and the choice among them."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from onnxruntime.quantization import (
    CalibrationDataReader,
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_dynamic,
    quantize_static,
)
from onnxruntime.quantization.shape_inference import quant_pre_process

from tools.models.export import save

LEAST = 0.98  # median cosine to float32 below which a version is not taken
SLOWEST = 1.25  # times float32's milliseconds, above which it is not
_FEW = 4  # convolutions: as many are a ViT's patch embedding, which stays in float32
_STEM = 3  # first convolutions, whose few channels have the most unequal ranges
_LARGE = 1 << 16  # numbers in a table worth storing in int8

FLOAT32 = "float32"


@dataclass(frozen=True)
class Version:
    """A graph of a tower: how it is stored, its median ``cosine`` to the source framework, and its speed."""

    name: str
    path: Path
    cosine: float
    milliseconds: float


def choose(
    versions: Iterable[tuple[str, Path]], cosine: Callable[[Path], float], milliseconds: Callable[[Path], float]
) -> Version:
    """Of ``versions``, float32 first, the first other one that is true enough and not too slow; else float32."""
    measured = (Version(name, path, cosine(path), milliseconds(path)) for name, path in versions)
    plain = next(measured)
    for version in measured:
        if version.cosine >= LEAST and version.milliseconds <= SLOWEST * plain.milliseconds:
            return version
    return plain


def image_versions(
    source: Path, work: Path, pictures: Callable[[], Iterator[np.ndarray]]
) -> Iterator[tuple[str, Path]]:
    """Float32, then int8 versions, the smallest first; ``pictures`` (1, 3, H, W) set the ranges of convolutions.

    Convolutions are static (QDQ, U8S8, per channel), the matrices of transformers dynamic: in ONNX Runtime each is slow
    the other way round.
    """
    yield FLOAT32, source
    names = [node.name for node in onnx.load(source, load_external_data=False).graph.node if node.op_type == "Conv"]
    if len(names) > _FEW:
        for title, left_out in (("int8", []), ("int8 but for the stem", names[:_STEM])):
            static, target = work / "static.onnx", work / f"image {len(left_out)}.onnx"
            _convolutions(source, static, pictures(), left_out)
            _matrices(static, target)
            yield title, target
    target = work / "image matrices.onnx"
    _matrices(source, target)
    yield "int8" if len(names) <= _FEW else "int8 matrices, float32 convolutions", target


def text_versions(source: Path, work: Path) -> Iterator[tuple[str, Path]]:
    """Float32, then int8: dynamic matrices, and a word table with one scale a word."""
    yield FLOAT32, source
    target = work / "text int8.onnx"
    _matrices(source, target)
    model = onnx.load(target)
    _tables(model.graph)
    save(model, target)
    yield "int8", target


def _convolutions(source: Path, target: Path, pictures: Iterator[np.ndarray], left_out: list[str]) -> None:
    ready = target.with_name("ready.onnx")
    quant_pre_process(source, ready, skip_symbolic_shape=True)
    quantize_static(
        ready, target, Pictures(pictures), quant_format=QuantFormat.QDQ,
        op_types_to_quantize=["Conv", "Relu", "Clip", "Add", "AveragePool", "MaxPool"], per_channel=True,
        activation_type=QuantType.QUInt8, weight_type=QuantType.QInt8, calibrate_method=CalibrationMethod.MinMax,
        nodes_to_exclude=left_out,
    )  # fmt: skip


def _matrices(source: Path, target: Path) -> None:
    quantize_dynamic(
        source, target, op_types_to_quantize=["MatMul", "Gemm"], weight_type=QuantType.QInt8, per_channel=True
    )
    save(onnx.load(target), target)


def _tables(graph: onnx.GraphProto) -> None:
    """Every large table that rows are picked from becomes Cast(Gather(int8 table)) * Gather(scales)."""
    tables = {
        tensor.name: tensor for tensor in graph.initializer if len(tensor.dims) == 2 and np.prod(tensor.dims) >= _LARGE
    }
    for gather in [node for node in graph.node if node.op_type == "Gather" and node.input[0] in tables]:
        name, ids, output = gather.input[0], gather.input[1], gather.output[0]
        values = numpy_helper.to_array(tables[name])
        scales = (np.maximum(np.abs(values).max(1, keepdims=True), 1e-8) / 127).astype(np.float32)
        graph.initializer.remove(tables.pop(name))
        graph.initializer.append(numpy_helper.from_array(np.rint(values / scales).astype(np.int8), f"{name}_rows_int8"))
        graph.initializer.append(numpy_helper.from_array(scales, f"{name}_rows_scale"))
        at = list(graph.node).index(gather)
        graph.node.remove(gather)
        for node in (
            helper.make_node("Mul", [f"{output}_row_float", f"{output}_row_scale"], [output]),
            helper.make_node("Gather", [f"{name}_rows_scale", ids], [f"{output}_row_scale"], axis=0),
            helper.make_node("Cast", [f"{output}_row_int8"], [f"{output}_row_float"], to=TensorProto.FLOAT),
            helper.make_node("Gather", [f"{name}_rows_int8", ids], [f"{output}_row_int8"], axis=0),
        ):
            graph.node.insert(at, node)


class Pictures(CalibrationDataReader):
    """Inputs ``image`` (1, 3, H, W) that set the ranges of a static quantization."""

    def __init__(self, pictures: Iterator[np.ndarray]):
        self._pictures = iter(pictures)

    def get_next(self):
        picture = next(self._pictures, None)
        return None if picture is None else {"image": picture}
