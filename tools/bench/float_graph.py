"""The shipped int8 image graph turned back into float32, so that anybody can time what int8 saves.

Only the shipped files are needed, not what they were made from. The graph computes the same tower at the same cost as
the original in float32; its weights are rounded to the int8 grid, which no processor notices.
"""

from pathlib import Path

import numpy as np
import onnx
from onnx import helper, numpy_helper


def dequantize(source: Path, target: Path) -> None:
    """Read the quantized graph ``source``, with its external data, and write it in float32 as one file.

    Handles what the exporter makes: QuantizeLinear/DequantizeLinear pairs around activations, DequantizeLinear of
    weights, and DynamicQuantizeLinear with MatMulInteger.
    """
    model = onnx.load(source)
    _Graph(model.graph).dequantize()
    onnx.save(model, target)


class _Graph:
    def __init__(self, graph: onnx.GraphProto):
        self.graph = graph
        self.weights = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
        self.maker = {name: node for node in graph.node for name in node.output}

    def dequantize(self) -> None:
        nodes, added, renamed = [], {}, {}
        for node in self.graph.node:
            if node.op_type == "DequantizeLinear" and node.input[0] in self.weights:
                added[node.output[0]] = self._weight(node)
            elif node.op_type == "DequantizeLinear":
                quantize = self.maker[node.input[0]]
                renamed[node.output[0]] = quantize.input[0]
                clip = self._clip(quantize, node.output[0], added)
                if clip is not None:
                    nodes.append(clip)
                    del renamed[node.output[0]]
            elif node.op_type == "Mul" and (product := self._product(node, added)) is not None:
                nodes.append(product)
            else:
                nodes.append(node)
        for node in nodes:
            for i, name in enumerate(node.input):
                while name in renamed:
                    name = renamed[name]
                node.input[i] = name
        self._replace(nodes, added)

    def _weight(self, node) -> np.ndarray:
        """(values - zero point) * scale, along the node's axis."""
        values, scale = self.weights[node.input[0]], self.weights[node.input[1]]
        zero = self.weights[node.input[2]] if len(node.input) > 2 else np.zeros_like(scale)
        axis = next((attribute.i for attribute in node.attribute if attribute.name == "axis"), 1)
        shape = [1] * values.ndim
        if scale.size > 1:
            shape[axis] = -1
            scale, zero = scale.reshape(shape), zero.reshape(shape)
        return ((values.astype(np.float32) - zero.astype(np.float32)) * scale).astype(np.float32)

    def _clip(self, quantize, output: str, added: dict):
        """The quantizer merged each ReLU6 into the range of the numbers behind it: those that start at 0."""
        scale, zero = self.weights[quantize.input[1]], self.weights[quantize.input[2]]
        if zero != np.iinfo(zero.dtype).min:
            return None
        added[f"{output}_low"] = np.array(0, np.float32)
        added[f"{output}_high"] = np.array(np.iinfo(zero.dtype).max * scale, np.float32)
        return helper.make_node("Clip", [quantize.input[0], f"{output}_low", f"{output}_high"], [output])

    def _product(self, node, added: dict):
        """MatMul in place of ``Cast(MatMulInteger) * (scale of x * scale of w)``; None for other products."""
        cast = self.maker.get(node.input[0])
        integer = self.maker.get(cast.input[0]) if cast is not None and cast.op_type == "Cast" else None
        if integer is None or integer.op_type != "MatMulInteger":
            return None
        scale = self.weights[self.maker[node.input[1]].input[1]]
        weight, zero = self.weights[integer.input[1]], self.weights[integer.input[3]]
        name = f"{node.output[0]}_weight"
        added[name] = ((weight.astype(np.float32) - zero.astype(np.float32)) * scale).astype(np.float32)
        return helper.make_node("MatMul", [self.maker[integer.input[0]].input[0], name], list(node.output))

    def _replace(self, nodes: list, added: dict) -> None:
        """Put in the new nodes, and leave out what they no longer reach."""
        wanted, kept = {output.name for output in self.graph.output}, []
        for node in reversed(nodes):
            if wanted & set(node.output):
                kept.insert(0, node)
                wanted.update(node.input)
        weights = {name: value for name, value in (self.weights | added).items() if name in wanted}
        del self.graph.node[:], self.graph.initializer[:], self.graph.value_info[:]
        self.graph.node.extend(kept)
        self.graph.initializer.extend(numpy_helper.from_array(value, name) for name, value in weights.items())
