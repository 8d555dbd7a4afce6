import numpy as np
import pytest

onnx = pytest.importorskip("onnx")

from edge.perception.preprocess import preprocess  # noqa: E402
from edge.perception.session import open_session  # noqa: E402
from models.manifest import Manifest, resolve  # noqa: E402
from tools.bench.float_graph import dequantize  # noqa: E402
from tools.models.reference import Reference  # noqa: E402


@pytest.fixture(scope="module")
def graph(tmp_path_factory):
    path = tmp_path_factory.mktemp("float") / "float32.onnx"
    dequantize(resolve() / "image.onnx", path)
    return path


def test_nothing_is_left_of_int8(graph):
    model = onnx.load(graph)
    onnx.checker.check_model(model)
    assert not {node.op_type for node in model.graph.node} & {
        "QuantizeLinear", "DequantizeLinear", "DynamicQuantizeLinear", "MatMulInteger",
    }  # fmt: skip
    sizes = [np.prod(t.dims) for t in model.graph.initializer if t.data_type == onnx.TensorProto.FLOAT]
    assert 4 * sum(sizes) > 15e6  # bytes: all weights in float32


def test_it_computes_what_pytorch_computed(graph):
    """Not only its cost is that of the tower in float32: its vectors are, too."""
    manifest, reference = Manifest.load(resolve()), Reference.load(resolve())
    session = open_session(graph)
    for rgb, expected in zip(reference.pictures(), reference.image):
        vectors = session.run(None, {"image": preprocess(rgb, manifest.image)})[0]
        assert vectors[0] @ expected[0] > 0.98
