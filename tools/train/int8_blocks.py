"""Matrices of a graph in int8, unpacked a block of rows at a time: never all of their float32 numbers at once."""

import numpy as np
import onnx
from onnx import helper, numpy_helper

ROWS = 64  # of a block; 64 x 1280 float32 are 0.3 MB, which stay in a small processor's cache while they are used


def store_in_blocks(graph: onnx.GraphProto) -> None:
    """Every product of a vector (1, N) with a matrix initializer becomes products with blocks of int8 rows and scales.

    The rows of each matrix, or of the one that it is the transpose of, must be on an int8 grid.
    """
    matrices = {t.name: numpy_helper.to_array(t) for t in graph.initializer if len(t.dims) == 2 and min(t.dims) > 1}
    stored: dict[bytes, str] = {}  # a matrix and its transpose are kept once
    nodes = []
    for node in graph.node:
        name = next((name for name in node.input if name in matrices), None)
        if name is None:
            nodes.append(node)
            continue
        values = matrices[name]
        # The exporter may have stored a transposed copy; the grid is along the rows of the original.
        lying = not _on_grid(values)
        rows = np.ascontiguousarray(values.T) if lying else values
        key = rows.tobytes()
        if key not in stored:
            stored[key] = name
            _store(graph, name, rows)
        onto_rows = node.op_type == "Gemm" or lying  # x W', one result a row; else x W, the sum over rows
        bias = node.input[2] if len(node.input) > 2 else None
        nodes += _product(node, stored[key], len(rows), onto_rows, bias)
    for tensor in [t for t in graph.initializer if t.name in matrices]:
        graph.initializer.remove(tensor)
    del graph.node[:]
    graph.node.extend(nodes)


def _store(graph: onnx.GraphProto, name: str, rows: np.ndarray) -> None:
    scales = _scales(rows)
    steps = np.rint(rows / scales).astype(np.int8)
    for first in range(0, len(rows), ROWS):
        block = slice(first, first + ROWS)
        graph.initializer.append(numpy_helper.from_array(steps[block], f"{name}_int8_{first}"))
        graph.initializer.append(numpy_helper.from_array(scales[block, 0], f"{name}_scale_{first}"))


def _product(node: onnx.NodeProto, name: str, height: int, onto_rows: bool, bias: str | None) -> list[onnx.NodeProto]:
    """``node``'s product of its first input with the stored matrix ``name``, block by block."""
    vector, (result,) = node.input[0], node.output
    starts = range(0, height, ROWS)
    nodes, parts = [], [f"{result}_{first}" for first in starts]
    vectors = [vector] * len(parts)
    if not onto_rows:
        vectors = [f"{part}_from" for part in parts]
        sizes = numpy_helper.from_array(np.array([min(ROWS, height - first) for first in starts]))
        nodes.append(helper.make_node("Constant", [], [f"{result}_sizes"], value=sizes))
        nodes.append(helper.make_node("Split", [vector, f"{result}_sizes"], vectors, axis=1))
    for first, part, x in zip(starts, parts, vectors):
        packed = [f"{name}_int8_{first}", f"{name}_scale_{first}"]
        nodes.append(helper.make_node("DequantizeLinear", packed, [f"{part}_rows"], axis=0))
        nodes.append(helper.make_node("Gemm", [x, f"{part}_rows"], [part], transB=int(onto_rows)))
    joined = result if bias is None else f"{result}_product"
    nodes.append(
        helper.make_node("Concat", parts, [joined], axis=1) if onto_rows else helper.make_node("Sum", parts, [joined])
    )
    if bias is not None:
        nodes.append(helper.make_node("Add", [joined, bias], [result]))
    return nodes


def _scales(rows: np.ndarray) -> np.ndarray:
    return np.maximum(np.abs(rows).max(1, keepdims=True), 1e-12).astype(np.float32) / 127


def _on_grid(rows: np.ndarray) -> bool:
    steps = rows / _scales(rows)
    return bool(np.abs(steps - np.rint(steps)).max() < 1e-2)
