"""An ONNX graph of float arithmetic as a PyTorch module, so that gradients can be had of it."""

from collections.abc import Callable

import onnx
import torch
from onnx import helper, numpy_helper
from torch import nn
from torch.nn import functional

from models.manifest import ModelError


class OnnxModule(nn.Module):
    """Runs a graph of fixed shapes from its first input to the value named ``output``.

    ``cut`` names a value on the way; it passes through the submodule ``at_cut``, where hooks can catch it.

    Raises:
        ModelError: the graph has an operator that is not known here, such as those of int8 graphs.
    """

    def __init__(self, graph: onnx.GraphProto, cut: str, output: str):
        super().__init__()
        self._input, self._cut, self._output = graph.input[0].name, cut, output
        self._nodes = [(n.op_type, list(n.input), list(n.output), _attributes(n)) for n in _needed(graph, output)]
        unknown = {operator for operator, *_ in self._nodes} - set(_OPERATORS)
        if unknown:
            raise ModelError(
                f"The image graph has {', '.join(sorted(unknown))}, through which no Grad-CAM is traced; "
                "give a float32 graph of plain operators."
            )
        self._constants = {tensor.name: torch.tensor(numpy_helper.to_array(tensor)) for tensor in graph.initializer}
        self.at_cut = nn.Identity()

    def forward(self, image):
        values = {"": None, self._input: image} | self._constants
        for operator, inputs, outputs, attributes in self._nodes:
            found = _OPERATORS[operator](*(values[name] for name in inputs), **attributes)
            values.update(zip(outputs, found if isinstance(found, tuple) else (found,)))
            if self._cut in outputs:
                values[self._cut] = self.at_cut(values[self._cut])
        return values[self._output]


def _needed(graph: onnx.GraphProto, output: str) -> list[onnx.NodeProto]:
    """The nodes that ``output`` depends on, in order."""
    wanted, nodes = {output}, []
    for node in reversed(graph.node):
        if wanted & set(node.output):
            wanted |= set(node.input)
            nodes.append(node)
    return nodes[::-1]


def _attributes(node: onnx.NodeProto) -> dict:
    values = {attribute.name: helper.get_attribute_value(attribute) for attribute in node.attribute}
    if node.op_type == "Constant":
        return {"value": torch.tensor(numpy_helper.to_array(values["value"]))} if "value" in values else values
    return values


def _conv(x, weight, bias=None, *, strides=(1, 1), pads=(0, 0, 0, 0), dilations=(1, 1), group=1, auto_pad=b"", **_):
    x = _padded(x, pads, auto_pad)
    return functional.conv2d(x, weight, bias, tuple(strides), 0, tuple(dilations), group)


def _padded(x, pads, auto_pad=b"", value=0.0):
    if auto_pad not in (b"", b"NOTSET", b"VALID"):
        raise ModelError("The image graph pads its pictures by auto_pad, which is not known here.")
    top, left, bottom, right = pads
    return functional.pad(x, (left, right, top, bottom), value=value) if any(pads) else x


def _gemm(a, b, c=None, *, alpha=1.0, beta=1.0, transA=0, transB=0):
    product = alpha * (a.T if transA else a) @ (b.T if transB else b)
    return product if c is None else product + beta * c


def _max_pool(x, *, kernel_shape, strides=None, pads=(0, 0, 0, 0), ceil_mode=0, **_):
    x = _padded(x, pads, value=float("-inf"))
    return functional.max_pool2d(x, tuple(kernel_shape), tuple(strides or (1, 1)), ceil_mode=bool(ceil_mode))


def _average_pool(x, *, kernel_shape, strides=None, pads=(0, 0, 0, 0), ceil_mode=0, count_include_pad=0, **_):
    if any(pads) and not count_include_pad:
        raise ModelError("The image graph averages over unequal windows at its edges, which is not known here.")
    x = _padded(x, pads)
    return functional.avg_pool2d(x, tuple(kernel_shape), tuple(strides or (1, 1)), ceil_mode=bool(ceil_mode))


def _norm(x, scale, bias, mean, variance, *, epsilon=1e-5, **_):
    return functional.batch_norm(x, mean, variance, scale, bias, eps=epsilon)


def _layer_norm(x, scale, bias=None, *, axis=-1, epsilon=1e-5, **_):
    return functional.layer_norm(x, x.shape[axis:], scale, bias, epsilon)


def _reduce(operation: Callable) -> Callable:
    def run(x, axes=None, *, keepdims=1, noop_with_empty_axes=0):
        return operation(x, list(range(x.dim())) if axes is None else _integers(axes), bool(keepdims))

    return run


def _integers(values) -> list[int]:
    """Of an input, or of the attribute that it was in older operator sets."""
    return list(values) if isinstance(values, (list, tuple)) else values.tolist()


def _reshape(x, shape, *, allowzero=0):
    return x.reshape([x.shape[i] if n == 0 and not allowzero else n for i, n in enumerate(shape.tolist())])


def _flatten(x, *, axis=1):
    return x.reshape(int(torch.tensor(x.shape[:axis]).prod()), -1)


def _slice(x, starts, ends, axes=None, steps=None):
    chosen = range(len(starts)) if axes is None else axes.tolist()
    for start, end, axis, step in zip(starts, ends, chosen, [1] * len(starts) if steps is None else steps.tolist()):
        length = x.shape[axis]
        start, end = (max(min(int(at) + (length if at < 0 else 0), length), 0) for at in (start, end))
        x = x[(slice(None),) * (axis % x.dim()) + (slice(start, end, step),)]
    return x


def _gather(x, indices, *, axis=0):
    if indices.dim() == 0:
        return x.select(axis, int(indices))
    return x.index_select(axis, indices.reshape(-1)).unflatten(axis, tuple(indices.shape))


def _split(x, sizes=None, *, axis=0, split=None, num_outputs=None):
    if sizes is None and split is None:
        return tuple(x.chunk(num_outputs, axis))
    return tuple(x.split(_integers(split or sizes), axis))


def _squeeze(x, axes):
    return x.squeeze(tuple(_integers(axes)))


def _unsqueeze(x, axes):
    for axis in sorted(axis % (x.dim() + len(axes)) for axis in _integers(axes)):
        x = x.unsqueeze(axis)
    return x


def _gelu(x, *, approximate=b"none"):
    return functional.gelu(x, approximate=approximate.decode())


_OPERATORS: dict[str, Callable] = {
    "Add": torch.add, "Sub": torch.sub, "Mul": torch.mul, "Div": torch.div, "Pow": torch.pow, "MatMul": torch.matmul,
    "Relu": torch.relu, "Sigmoid": torch.sigmoid, "Tanh": torch.tanh, "Erf": torch.erf, "Exp": torch.exp,
    "Log": torch.log, "Sqrt": torch.sqrt, "Neg": torch.neg, "Abs": torch.abs, "Reciprocal": torch.reciprocal,
    "Max": torch.maximum, "Min": torch.minimum, "HardSwish": functional.hardswish, "Gelu": _gelu, "Conv": _conv,
    "Gemm": _gemm,
    "HardSigmoid": lambda x, alpha=0.2, beta=0.5: (alpha * x + beta).clamp(0, 1),
    "LeakyRelu": lambda x, alpha=0.01: functional.leaky_relu(x, alpha),
    "Clip": lambda x, low=None, high=None: torch.clamp(x, low, high),
    "Softmax": lambda x, axis=-1: torch.softmax(x, axis),
    "MaxPool": _max_pool, "AveragePool": _average_pool, "BatchNormalization": _norm, "LayerNormalization": _layer_norm,
    "GlobalAveragePool": lambda x: x.mean((2, 3), keepdim=True),
    "ReduceMean": _reduce(lambda x, axes, keep: x.mean(axes, keep)),
    "ReduceSum": _reduce(lambda x, axes, keep: x.sum(axes, keep)),
    "ReduceL2": _reduce(lambda x, axes, keep: (x * x).sum(axes, keep).sqrt()),
    "LpNormalization": lambda x, axis=-1, p=2: functional.normalize(x, p=float(p), dim=axis),
    "Reshape": _reshape, "Flatten": _flatten, "Slice": _slice, "Gather": _gather, "Split": _split, "Squeeze": _squeeze,
    "Unsqueeze": _unsqueeze, "Transpose": lambda x, perm: x.permute(tuple(perm)),
    "Concat": lambda *parts, axis: torch.cat(parts, axis),
    "Expand": lambda x, shape: x.expand(torch.broadcast_shapes(x.shape, tuple(shape.tolist()))),
    "Identity": lambda x: x, "Dropout": lambda x, *_, **__: x, "Constant": lambda value: value,
    "Cast": lambda x, to: x.to({1: torch.float32, 6: torch.int32, 7: torch.int64, 9: torch.bool}[to]),
}  # fmt: skip
