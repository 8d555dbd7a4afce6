"""Products with blocks of int8 rows, against the same with the whole float32 matrix."""

import numpy as np
import pytest

onnx = pytest.importorskip("onnx")

from onnx import TensorProto, helper, numpy_helper  # noqa: E402
from onnxruntime import InferenceSession  # noqa: E402

from tools.train.int8_blocks import ROWS, store_in_blocks  # noqa: E402

HEIGHT, WIDTH = 2 * ROWS + 5, 7


@pytest.fixture
def model():
    """x W' + b, then that times W, and the product with a transposed copy of W: one matrix in three roles."""
    rng = np.random.default_rng(0)
    steps = rng.integers(-127, 128, (HEIGHT, WIDTH))
    steps[:, 0] = 127  # each row reaches the end of its grid
    rows = (steps * rng.uniform(0.001, 0.01, (HEIGHT, 1))).astype(np.float32)
    tensors = {"W": rows, "T": np.ascontiguousarray(rows.T), "b": rng.normal(size=HEIGHT).astype(np.float32)}
    nodes = [
        helper.make_node("Gemm", ["x", "W", "b"], ["high"], transB=1),
        helper.make_node("MatMul", ["high", "W"], ["back"]),
        helper.make_node("MatMul", ["x", "T"], ["again"]),
    ]
    widths = {"high": HEIGHT, "back": WIDTH, "again": HEIGHT}
    outputs = [helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, width]) for name, width in widths.items()]
    graph = helper.make_graph(
        nodes,
        "products",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, WIDTH])],
        outputs,
        [numpy_helper.from_array(values, name) for name, values in tensors.items()],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)


def outputs(model):
    onnx.checker.check_model(model)
    x = np.random.default_rng(1).normal(size=(1, WIDTH)).astype(np.float32)
    return InferenceSession(model.SerializeToString()).run(None, {"x": x})


def test_the_products_are_the_same(model):
    expected = outputs(model)
    store_in_blocks(model.graph)
    for got, want in zip(outputs(model), expected, strict=True):
        np.testing.assert_allclose(got, want, rtol=1e-5, atol=1e-5)


def test_the_matrix_is_stored_once_in_int8(model):
    store_in_blocks(model.graph)
    tables = [numpy_helper.to_array(tensor) for tensor in model.graph.initializer if len(tensor.dims) == 2]
    assert [table.dtype for table in tables] == [np.int8] * 3
    assert sum(len(table) for table in tables) == HEIGHT and max(len(table) for table in tables) == ROWS
