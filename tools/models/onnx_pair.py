"""A pair of ready ONNX graphs with a tokenizer, as other exporters leave them."""

import json
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper
from tokenizers import Tokenizer

from edge.perception.session import onnxruntime, open_session
from models.manifest import ModelError
from tools.models.export import export_graph
from tools.models.grad_cam import export_saliency
from tools.models.huggingface import normalization
from tools.models.loading import loading
from tools.models.onnx_module import OnnxModule
from tools.models.pair import IMAGE, SALIENCY, TEXT, TOKENIZER, Pair
from tools.models.tower import Tower

_IMAGES, _TEXTS = ("image.onnx", "vision_model.onnx", "visual.onnx"), ("text.onnx", "text_model.onnx", "textual.onnx")
_SIZE, _CONTEXT = 224, 77  # px and tokens, where graphs and folder leave them open
_SCALE = 100.0  # where CLIP's training ends; the graphs do not keep it


def from_folder(folder: Path, source: str, licence: str) -> Pair:
    """A folder with an image graph, a text graph and ``tokenizer.json``; with Hugging Face's configurations, if there.

    The graphs are float32. The first takes pixels (1, 3, H, W), the second token ids (1, T) and perhaps a mask, each
    gives vectors of one space. Grad-CAM is traced through the image graph, run by PyTorch.

    Raises:
        ModelError: a file is missing, or the graphs are not of that form.
    """
    image, text, words = _find(folder, _IMAGES), _find(folder, _TEXTS), _find(folder, (TOKENIZER,))
    config = folder / "config.json"
    with loading(source):
        config = json.loads(config.read_text()) if config.is_file() else {}
        tokenizer = Tokenizer.from_file(str(words))
        size = _size(image, folder)
        graph = _folded(image, size)
        output = _vectors(graph.output, source)
        cut, kind = _last_map(graph)
        text_graph = _robots_text(onnx.load(text), source)
    context = config.get("text_config", {}).get("max_position_embeddings") or _length(text_graph) or _CONTEXT
    fixed = bool(_length(text_graph)) or config.get("model_type") == "siglip"
    pad_id = (tokenizer.padding or {}).get("pad_id", config.get("text_config", {}).get("pad_token_id") or 0)
    tokenizer.no_padding()
    tokenizer.enable_truncation(context)
    mean, std = normalization(folder, config.get("model_type", "clip"))

    def see(pixels):
        session = open_session(image)
        (found,) = session.run([output], {session.get_inputs()[0].name: pixels})
        return found[0] / np.linalg.norm(found[0])

    def read(prompt):
        if fixed:
            tokenizer.enable_padding(length=context, pad_id=pad_id)
        tokens = tokenizer.encode(prompt)
        session = open_session(text)
        feeds = {}
        for theirs in session.get_inputs():
            values = tokens.attention_mask if "mask" in theirs.name else tokens.ids
            feeds[theirs.name] = np.array([values], np.int32 if "int32" in theirs.type else np.int64)
        (found,) = session.run([_vectors(onnx.load(text, load_external_data=False).graph.output, source)], feeds)
        return found[0] / np.linalg.norm(found[0])

    def export(target):
        module = OnnxModule(graph, cut, output).eval()
        tower = Tower(module, module, module.at_cut, size)
        export_graph(tower, (torch.zeros(1, 3, *size),), target / IMAGE, ["image"], ["vectors", *tower.names])
        export_saliency(tower, target / SALIENCY)
        onnx.save(text_graph, target / TEXT)
        tokenizer.no_padding()
        tokenizer.save(str(target / TOKENIZER))

    return Pair(
        source=source, licence=licence, kind=kind, height=size[0], width=size[1], mean=mean, std=std,
        logit_scale=_SCALE, context_length=context, pad_id=pad_id if fixed else None, export=export, see=see, read=read,
    )  # fmt: skip


def _find(folder: Path, names: tuple[str, ...]) -> Path:
    for path in (place / name for name in names for place in (folder, folder / "onnx")):
        if path.is_file():
            return path
    raise ModelError(f"{folder} has no {' or '.join(names)}.")


def _size(image: Path, folder: Path) -> tuple[int, int]:
    """Height and width [px] of the input, from the graph or, where it is open there, from the folder."""
    dims = onnx.load(image, load_external_data=False).graph.input[0].type.tensor_type.shape.dim
    height, width = (dim.dim_value for dim in dims[2:4])
    path = folder / "preprocessor_config.json"
    if not height and path.is_file():
        stated = json.loads(path.read_text()).get("size", _SIZE)
        height = stated if isinstance(stated, int) else stated.get("height") or stated.get("shortest_edge")
    return height or _SIZE, width or height or _SIZE


def _folded(image: Path, size: tuple[int, int]) -> onnx.GraphProto:
    """The graph for one picture of ``size``, with everything computed that is known beforehand, and all shapes."""
    model = onnx.load(image)
    for dim, value in zip(model.graph.input[0].type.tensor_type.shape.dim, (1, 3, *size)):
        dim.dim_value = value
    for output in model.graph.output:
        for dim in output.type.tensor_type.shape.dim:
            dim.Clear()
    with TemporaryDirectory() as work:
        plain, folded = Path(work) / "plain.onnx", Path(work) / "folded.onnx"
        onnx.save(model, plain)
        options = onnxruntime.SessionOptions()
        options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_BASIC
        options.optimized_model_filepath, options.log_severity_level = str(folded), 3
        onnxruntime.InferenceSession(str(plain), options, providers=["CPUExecutionProvider"])
        return onnx.shape_inference.infer_shapes(onnx.load(folded)).graph


def _vectors(outputs, source: str) -> str:
    """The name of the output with rows of numbers; of several, the one that is called embeddings or the like."""
    ranks = {output.name: len(output.type.tensor_type.shape.dim) for output in outputs}
    rows = [name for name, rank in ranks.items() if rank == 2]
    if not rows:
        raise ModelError(f"{source}: a graph gives {', '.join(ranks)}, none of which has the form (1, D).")
    return next((name for name in rows if any(word in name for word in ("embed", "vector", "feature"))), rows[0])


def _last_map(graph: onnx.GraphProto) -> tuple[str, str]:
    """The value to cut at, and the kind of tower: a CNN's last map, or what enters a transformer's last block."""
    shapes = {value.name: [dim.dim_value for dim in value.type.tensor_type.shape.dim] for value in graph.value_info}
    convolutions = [i for i, node in enumerate(graph.node) if node.op_type == "Conv"]
    wide = [i for i in convolutions if np.prod(shapes.get(graph.node[i].output[0], [0])[2:]) > 1]
    attentions = [i for i, node in enumerate(graph.node) if node.op_type == "Softmax" and wide and i > wide[-1]]
    if wide and len(attentions) <= 1:
        form = shapes[graph.node[wide[-1]].output[0]]
        return [name for node in graph.node for name in node.output if shapes.get(name) == form][-1], "CNN, ready graph"
    known = {tensor.name for tensor in graph.initializer}
    sums = [node.output[0] for node in graph.node if node.op_type == "Add" and not known & set(node.input)]
    forms = Counter(tuple(shapes.get(name, ())) for name in sums)
    usual = max((form for form in forms if len(form) == 3 and form[0] == 1), key=forms.get, default=None)
    residuals = [name for name in sums if tuple(shapes.get(name, ())) == usual]
    if len(residuals) < 3:
        raise ModelError("The image graph has neither a last map of convolutions nor a last block that is recognized.")
    return residuals[-3], "ViT, ready graph"  # a block adds twice: what it attended to, and what it made of that


def _robots_text(model: onnx.ModelProto, source: str) -> onnx.ModelProto:
    """The graph with the names, types and unit vectors that the robot expects."""
    graph = model.graph
    output = _vectors(graph.output, source)
    masks = [value for value in graph.input if "mask" in value.name]
    others = [value for value in graph.input if value not in masks]
    if len(others) != 1 or len(masks) > 1:
        names = ", ".join(value.name for value in graph.input)
        raise ModelError(f"{source}: the text graph takes {names}, not token ids and perhaps a mask.")
    inputs = []
    for ours, value in zip(("input_ids", "attention_mask"), others + masks):
        tensor = value.type.tensor_type
        length = tensor.shape.dim[1].dim_value or "length"
        inputs.append(helper.make_tensor_value_info(ours, TensorProto.INT64, [1, length]))
        theirs = value.name if value.name != ours else f"{ours}_theirs"
        for node in graph.node:
            node.input[:] = [theirs if name == value.name else name for name in node.input]
        graph.node.insert(0, helper.make_node("Cast", [ours], [theirs], to=tensor.elem_type))
    graph.node.append(helper.make_node("LpNormalization", [output], ["embedding"], axis=-1, p=2))
    del graph.input[:], graph.output[:]
    graph.input.extend(inputs)
    graph.output.append(helper.make_tensor_value_info("embedding", TensorProto.FLOAT, [1, None]))
    return model


def _length(model: onnx.ModelProto) -> int:
    """Tokens, if the graph takes a fixed number; else 0."""
    return model.graph.input[0].type.tensor_type.shape.dim[1].dim_value
