"""With the import extra only: every operator gives what ONNX Runtime gives."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")
onnx = pytest.importorskip("onnx")
pytest.importorskip("safetensors")

from onnx import TensorProto, helper, numpy_helper  # noqa: E402

from edge.perception.session import onnxruntime  # noqa: E402
from models.manifest import ModelError  # noqa: E402
from tools.models.onnx_module import OnnxModule  # noqa: E402

IMAGE = (1, 4, 6, 8)
RNG = np.random.default_rng(0)
KERNEL, BIAS = RNG.normal(size=(4, 2, 3, 3)).astype(np.float32), RNG.normal(size=4).astype(np.float32)
ROW = RNG.normal(size=8).astype(np.float32)
MATRIX = RNG.normal(size=(8, 5)).astype(np.float32)


def integers(*values):
    return np.array(values, np.int64)


# (operator, further inputs, attributes, operator set)
CASES = [
    *((name, [], {}, 17) for name in ("Relu", "Sigmoid", "Tanh", "Erf", "Exp", "Neg", "Abs", "Identity", "HardSwish")),
    *((name, [np.abs(ROW) + 1], {}, 17) for name in ("Add", "Sub", "Mul", "Div", "Max", "Min")),
    ("Pow", [np.float32(2.0)], {}, 17),
    ("Clip", [np.float32(-0.5), np.float32(0.5)], {}, 17),
    ("HardSigmoid", [], {"alpha": 0.1666, "beta": 0.5}, 17),
    ("LeakyRelu", [], {"alpha": 0.2}, 17),
    ("Softmax", [], {"axis": -1}, 17),
    ("Softmax", [], {"axis": 1}, 17),
    ("Conv", [KERNEL, BIAS], {"kernel_shape": [3, 3], "strides": [2, 1], "pads": [1, 0, 1, 2], "group": 2}, 17),
    ("Conv", [KERNEL], {"kernel_shape": [3, 3], "dilations": [2, 1], "group": 2}, 17),
    ("BatchNormalization", [BIAS, BIAS, BIAS, np.abs(BIAS)], {"epsilon": 1e-3}, 17),
    ("LayerNormalization", [ROW, ROW], {"axis": -1, "epsilon": 1e-6}, 17),
    ("MaxPool", [], {"kernel_shape": [3, 3], "strides": [2, 2], "pads": [1, 1, 1, 1]}, 17),
    ("AveragePool", [], {"kernel_shape": [2, 2], "strides": [2, 2]}, 17),
    ("AveragePool", [], {"kernel_shape": [3, 3], "pads": [1, 1, 1, 1], "count_include_pad": 1}, 17),
    ("GlobalAveragePool", [], {}, 17),
    ("MatMul", [MATRIX], {}, 17),
    ("ReduceMean", [], {"axes": [2, 3], "keepdims": 0}, 17),
    ("ReduceMean", [integers(-1)], {}, 18),
    ("ReduceMean", [], {}, 17),
    ("ReduceSum", [integers(1)], {"keepdims": 0}, 17),
    ("ReduceL2", [], {"axes": [1]}, 17),
    ("LpNormalization", [], {"axis": 1, "p": 2}, 17),
    ("Reshape", [integers(0, 2, -1)], {}, 17),
    ("Flatten", [], {"axis": 2}, 17),
    ("Transpose", [], {"perm": [0, 2, 3, 1]}, 17),
    ("Slice", [integers(1, -3), integers(1000, -1), integers(2, 3)], {}, 17),
    ("Slice", [integers(0), integers(8), integers(-1), integers(3)], {}, 17),
    ("Gather", [np.int64(1)], {"axis": 1}, 17),
    ("Gather", [integers(2, 0)], {"axis": -1}, 17),
    ("Split", [integers(1, 3)], {"axis": 1}, 17),
    ("Squeeze", [integers(0)], {}, 17),
    ("Squeeze", [], {"axes": [0]}, 11),
    ("Unsqueeze", [integers(0, 2)], {}, 17),
    ("Unsqueeze", [], {"axes": [1]}, 11),
    ("Expand", [integers(3, 1, 1, 8)], {}, 17),
    ("Concat", [RNG.normal(size=IMAGE).astype(np.float32)], {"axis": 2}, 17),
    ("Cast", [], {"to": TensorProto.INT64}, 17),
    ("Gelu", [], {"approximate": "tanh"}, 20),
]


def model(operator, further, attributes, version, inputs=("x",)):
    names = [f"c{i}" for i in range(len(further))]
    outputs = ["y"] if operator != "Split" else ["y", "rest"]
    node = helper.make_node(operator, [*inputs, *names], outputs, **attributes)
    graph = helper.make_graph(
        [node], "g", [helper.make_tensor_value_info("x", TensorProto.FLOAT, IMAGE)],
        [helper.make_tensor_value_info("y", TensorProto.INT64 if operator == "Cast" else TensorProto.FLOAT, None)],
        [numpy_helper.from_array(np.asarray(value), name) for name, value in zip(names, further)],
    )  # fmt: skip
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", version)], ir_version=9)


@pytest.mark.parametrize(("operator", "further", "attributes", "version"), CASES)
def test_an_operator(operator, further, attributes, version):
    made = model(operator, further, attributes, version)
    x = np.random.default_rng(1).normal(size=IMAGE).astype(np.float32)
    session = onnxruntime.InferenceSession(made.SerializeToString(), providers=["CPUExecutionProvider"])
    (expected,) = session.run(["y"], {"x": x})
    found = OnnxModule(made.graph, "y", "y")(torch.tensor(x)).numpy()
    assert found.dtype == expected.dtype
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_gemm():
    rows = [helper.make_node("Flatten", ["x"], ["rows"], axis=3)]
    made = model("Gemm", [MATRIX.T, MATRIX[0]], {"alpha": 0.5, "beta": 2.0, "transB": 1}, 17, inputs=("rows",))
    made.graph.node.insert(0, rows[0])
    x = np.random.default_rng(1).normal(size=IMAGE).astype(np.float32)
    (expected,) = onnxruntime.InferenceSession(made.SerializeToString()).run(None, {"x": x})
    np.testing.assert_allclose(OnnxModule(made.graph, "rows", "y")(torch.tensor(x)).numpy(), expected, atol=1e-5)


def test_the_cut_can_be_caught():
    made = model("Relu", [], {}, 17)
    module = OnnxModule(made.graph, "y", "y")
    module.at_cut.register_forward_hook(lambda *_: torch.zeros(1))
    assert module(torch.ones(IMAGE)).tolist() == [0]


@pytest.mark.parametrize(
    ("operator", "attributes", "words"),
    [
        ("Conv", {"kernel_shape": [3, 3], "auto_pad": "SAME_UPPER", "group": 2}, "auto_pad"),
        ("AveragePool", {"kernel_shape": [3, 3], "pads": [1, 1, 1, 1]}, "unequal windows"),
        ("Sin", {}, "has Sin, through which no Grad-CAM"),
    ],
)
def test_what_is_not_known_is_told(operator, attributes, words):
    made = model(operator, [KERNEL] if operator == "Conv" else [], attributes, 17)
    with pytest.raises(ModelError, match=words):
        OnnxModule(made.graph, "y", "y")(torch.ones(IMAGE))
