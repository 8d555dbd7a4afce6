"""Grad-CAM of any tower as a plain forward graph: the tail's backward pass is traced, not run by autograd."""

from pathlib import Path

import torch
from torch import nn
from torch._decomp import core_aten_decompositions
from torch.fx import GraphModule
from torch.fx.experimental.proxy_tensor import make_fx
from torch.nn.attention import SDPBackend, sdpa_kernel

from models.manifest import ModelError
from tools.models.export import export_graph
from tools.models.tower import Tower

aten = torch.ops.aten


def grad_cam(tower: Tower, direction, *maps):
    """Grad-CAM (h, w) >= 0 of the vector dotted with ``direction`` (D,), at the first of ``maps``, the spatial one.

    Selvaraju et al. 2017: each channel weighs as much as its gradient, averaged over the cells, says. Times the number
    of cells, as in the shipped model's closed form. For a ViT, the layer is the tokens that enter the last block, and
    patches alone are shown.
    """
    _, backward = torch.func.vjp(lambda features: tower.tail(features, *maps[1:]), maps[0])
    (gradient,) = backward(direction[None])
    weights = gradient.sum((2, 3), keepdim=True)
    return torch.relu((weights * maps[0]).sum(1)[0])


def trace(tower: Tower) -> GraphModule:
    """``grad_cam`` as a graph of elementary operations with inputs direction (D,) and the maps."""
    inputs = torch.ones(tower.dim), *(torch.ones(shape) for shape in tower.shapes)
    run = torch.func.functionalize(lambda *tensors: grad_cam(tower, *tensors), remove="mutations")
    with sdpa_kernel(SDPBackend.MATH):  # the fused kernels' backward passes are no elementary operations
        steps = core_aten_decompositions()
        steps[aten.convolution_backward.default] = _convolution_backward
        graph = make_fx(run, decomposition_table=steps)(*inputs)
    for node in graph.graph.nodes:
        if node.target is aten._softmax.default:  # which the exporter does not know
            node.target, node.args = aten.softmax.int, node.args[:2]
    graph.graph.eliminate_dead_code()
    graph.recompile()
    return graph


def export_saliency(tower: Tower, path: Path) -> None:
    """Write the graph from ``direction`` (D,) and the tower's maps, by their names, to ``map`` (h, w)."""
    inputs = torch.zeros(tower.dim), *(torch.zeros(shape) for shape in tower.shapes)
    export_graph(_Called(trace(tower)), inputs, path, ["direction", *tower.names], ["map"])


def _convolution_backward(
    gradient, features, weight, bias, stride, padding, dilation, transposed, output_padding, groups, wanted
):
    """The gradient with respect to a two-dimensional convolution's input, the only one that a frozen tower has."""
    if transposed or any(wanted[1:]):
        raise ModelError("the image tower has a transposed or trainable convolution after its last map; choose another")
    missing = [
        features.shape[i + 2]
        - ((gradient.shape[i + 2] - 1) * stride[i] - 2 * padding[i] + dilation[i] * (weight.shape[i + 2] - 1) + 1)
        for i in range(2)
    ]
    found = torch.conv_transpose2d(gradient, weight, None, stride, padding, missing, groups, dilation)
    return found, None, None


class _Called(nn.Module):
    """The exporter names the inputs of ``forward`` by position; a traced graph has but odd names for them."""

    def __init__(self, graph: GraphModule):
        super().__init__()
        self.graph = graph

    def forward(self, *tensors):
        return self.graph(*tensors)
