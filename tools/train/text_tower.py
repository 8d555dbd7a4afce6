"""The locked text tower: all-MiniLM-L6-v2 as one ONNX graph, from token ids to a unit sentence embedding, in int8."""

import json
from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper
from onnxruntime.quantization import QuantType, quantize_dynamic
from safetensors.torch import load_file
from torch import nn
from torch.nn import functional


class _Layer(nn.Module):
    """One post-norm BERT layer (Devlin et al. 2019)."""

    def __init__(self, width: int, hidden: int, heads: int, eps: float):
        super().__init__()
        self.heads = heads
        self.query, self.key, self.value = (nn.Linear(width, width) for _ in range(3))
        self.attended = nn.Linear(width, width)
        self.attention_norm = nn.LayerNorm(width, eps)
        self.expand, self.shrink = nn.Linear(width, hidden), nn.Linear(hidden, width)
        self.output_norm = nn.LayerNorm(width, eps)

    def forward(self, x, bias):
        batch, length, width = x.shape
        split = lambda t: t.reshape(batch, length, self.heads, width // self.heads).transpose(1, 2)  # noqa: E731
        scores = split(self.query(x)) @ split(self.key(x)).transpose(2, 3) / (width // self.heads) ** 0.5
        mixed = torch.softmax(scores + bias, -1) @ split(self.value(x))
        x = self.attention_norm(x + self.attended(mixed.transpose(1, 2).reshape(batch, length, width)))
        return self.output_norm(x + self.shrink(functional.gelu(self.expand(x))))


class TextTower(nn.Module):
    """BERT encoder, mean over the tokens that the mask keeps, L2 norm: (B, T) int64 ids and mask to (B, D) float32."""

    NAMES = {
        "query": "attention.self.query",
        "key": "attention.self.key",
        "value": "attention.self.value",
        "attended": "attention.output.dense",
        "attention_norm": "attention.output.LayerNorm",
        "expand": "intermediate.dense",
        "shrink": "output.dense",
        "output_norm": "output.LayerNorm",
    }

    def __init__(self, config: dict):
        super().__init__()
        width, eps = config["hidden_size"], config["layer_norm_eps"]
        self.words = nn.Embedding(config["vocab_size"], width)
        self.positions = nn.Embedding(config["max_position_embeddings"], width)
        self.kinds = nn.Embedding(config["type_vocab_size"], width)
        self.norm = nn.LayerNorm(width, eps)
        self.layers = nn.ModuleList(
            _Layer(width, config["intermediate_size"], config["num_attention_heads"], eps)
            for _ in range(config["num_hidden_layers"])
        )

    @classmethod
    def load(cls, folder: Path) -> "TextTower":
        """From a folder with ``config.json`` and ``model.safetensors`` in Hugging Face's BERT naming."""
        tower = cls(json.loads((folder / "config.json").read_text()))
        theirs = load_file(folder / "model.safetensors")
        ours = {}
        embeddings = {"words": "word", "positions": "position", "kinds": "token_type"}
        for name, their in embeddings.items():
            ours[f"{name}.weight"] = theirs[f"embeddings.{their}_embeddings.weight"]
        for kind in ("weight", "bias"):
            ours[f"norm.{kind}"] = theirs[f"embeddings.LayerNorm.{kind}"]
            for i in range(len(tower.layers)):
                for name, their in cls.NAMES.items():
                    ours[f"layers.{i}.{name}.{kind}"] = theirs[f"encoder.layer.{i}.{their}.{kind}"]
        tower.load_state_dict(ours)
        return tower.eval()

    def forward(self, input_ids, attention_mask):
        x = self.words(input_ids) + self.positions.weight[: input_ids.shape[1]] + self.kinds.weight[0]
        x = self.norm(x)
        bias = (1.0 - attention_mask[:, None, None, :].float()) * -1e9
        for layer in self.layers:
            x = layer(x, bias)
        kept = attention_mask[:, :, None].float()
        return functional.normalize((x * kept).sum(1) / kept.sum(1), dim=1)


def export(tower: TextTower, path: Path) -> None:
    """Write the float32 ONNX graph (opset 17, dynamic batch and length)."""
    ids = torch.ones(2, 8, dtype=torch.int64)
    torch.onnx.export(
        tower,
        (ids, ids),
        str(path),
        input_names=["input_ids", "attention_mask"],
        output_names=["embedding"],
        dynamic_axes={name: {0: "batch", 1: "length"} for name in ("input_ids", "attention_mask")}
        | {"embedding": {0: "batch"}},
        opset_version=17,
        dynamo=False,
    )


def quantize(source: Path, target: Path) -> None:
    """Dynamic int8 MatMuls (per channel) and an int8 word table (one scale a word), weights as external data."""
    target.parent.mkdir(parents=True, exist_ok=True)
    quantize_dynamic(source, target, op_types_to_quantize=["MatMul"], weight_type=QuantType.QInt8, per_channel=True)
    model = onnx.load(target)
    _quantize_table(model.graph)
    data = target.name + ".data"
    target.with_name(data).unlink(missing_ok=True)
    onnx.save(model, target, save_as_external_data=True, location=data, size_threshold=1024)


def _quantize_table(graph: onnx.GraphProto) -> None:
    """Replace the Gather from the word table by Cast(Gather(int8 table)) * Gather(scales)."""
    table = max(graph.initializer, key=lambda t: np.prod(t.dims))
    gather = next(node for node in graph.node if node.op_type == "Gather" and node.input[0] == table.name)
    values = numpy_helper.to_array(table)
    scales = np.maximum(np.abs(values).max(1, keepdims=True), 1e-8) / 127
    graph.initializer.remove(table)
    rounded = np.rint(values / scales).astype(np.int8)
    graph.initializer.append(numpy_helper.from_array(rounded, "words_int8"))
    graph.initializer.append(numpy_helper.from_array(scales.astype(np.float32), "words_scale"))
    ids, output = gather.input[1], gather.output[0]
    at = list(graph.node).index(gather)
    graph.node.remove(gather)
    for node in reversed(
        [
            helper.make_node("Gather", ["words_int8", ids], ["words_picked"], axis=0),
            helper.make_node("Cast", ["words_picked"], ["words_float"], to=TensorProto.FLOAT),
            helper.make_node("Gather", ["words_scale", ids], ["words_scale_picked"], axis=0),
            helper.make_node("Mul", ["words_float", "words_scale_picked"], [output]),
        ]
    ):
        graph.node.insert(at, node)
