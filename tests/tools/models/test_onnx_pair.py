"""With the import extra only: ready graphs, exported by PyTorch alone, come in like their frameworks' models."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
timm = pytest.importorskip("timm")
pytest.importorskip("onnx")
pytest.importorskip("safetensors")

from torch import nn  # noqa: E402
from torch.nn import functional  # noqa: E402

from edge.perception.session import open_session  # noqa: E402
from models.manifest import ModelError  # noqa: E402
from tools.models.clip_tokenizer import tokenizer_json  # noqa: E402
from tools.models.export import export_graph  # noqa: E402
from tools.models.grad_cam import grad_cam  # noqa: E402
from tools.models.pair import CLIP_MEAN, IMAGE, SALIENCY, TEXT, TOKENIZER  # noqa: E402
from tools.models.parity import PROMPTS, token_ids  # noqa: E402
from tools.models.source import open_source  # noqa: E402
from tools.models.tower import Tower  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")

LETTERS = "abcdefghijklmnopqrstuvwxyz0123456789,!"


class Words(nn.Module):
    """A text tower that minds the mask, and does not normalize."""

    def __init__(self, masked):
        super().__init__()
        self.letters, self.head, self.masked = nn.Embedding(2 * len(LETTERS) + 2, 16), nn.Linear(16, 24), masked

    def forward(self, ids, mask=None):
        kept = torch.ones_like(ids) if mask is None else mask
        return self.head((self.letters(ids.long()) * kept[..., None]).sum(1))


def vit():
    made = timm.create_model("vit_tiny_patch16_224", img_size=64, embed_dim=48, depth=3, num_heads=4, num_classes=24)
    return made, made.blocks[-1]


def resnet():
    made = timm.create_model("resnet18", num_classes=24)
    return made, made.global_pool


def mobile():
    made = timm.create_model("mobilenetv3_small_050", num_classes=24)
    return made, made.global_pool


@pytest.fixture
def folder(tmp_path):
    """Writes a folder of ready graphs for an image tower; returns it, the tower and the text tower."""

    def write(make, length=None, masked=True):
        torch.manual_seed(0)
        image, cut = make()
        image, text, place = image.eval().requires_grad_(False), Words(masked).eval(), tmp_path / "ready"
        place.mkdir()
        picture = torch.zeros(2, 3, 64, 64)
        axes = {"pixel_values": {0: "batch", 2: "height", 3: "width"}}
        export_graph(image, (picture,), place / "vision_model.onnx", ["pixel_values"], ["image_embeds"], axes)
        ids = torch.ones(1, length or 5, dtype=torch.int32)
        names = ["ids", "attention_mask"][: 1 + masked]
        dynamic = None if length else {name: {0: "batch", 1: "length"} for name in names}
        arguments = (ids, torch.ones_like(ids))[: 1 + masked]
        export_graph(text, arguments, place / "text_model.onnx", names, ["text_embeds"], dynamic)
        pieces = [piece for letter in LETTERS for piece in (letter, f"{letter}</w>")]
        vocabulary = {token: i for i, token in enumerate(["<start>", "<end>", *pieces])}
        (place / TOKENIZER).write_text(tokenizer_json(vocabulary, [], "<start>", "<end>"))
        (place / "preprocessor_config.json").write_text(json.dumps({"size": {"height": 64, "width": 64}}))
        return place, image, cut, text

    return write


@pytest.mark.parametrize("make", [vit, resnet, mobile])
def test_ready_graphs_are_exported_as_they_are(make, folder, tmp_path):
    source, image, cut, text = folder(make)
    pair = open_source(str(source))
    assert (pair.height, pair.width, pair.mean, pair.context_length, pair.pad_id) == (64, 64, CLIP_MEAN, 77, None)
    pair.export(tmp_path)
    pixels = torch.randn(1, 3, 64, 64, generator=torch.Generator().manual_seed(0))
    session = open_session(tmp_path / IMAGE)
    vectors, *maps = session.run(None, {"image": pixels.numpy()})
    np.testing.assert_allclose(vectors, functional.normalize(image(pixels), dim=-1), atol=1e-5)
    np.testing.assert_allclose(pair.see(pixels.numpy()), vectors[0], atol=1e-5)
    tower = Tower(image, image, cut, (64, 64))
    expected_maps = tower(pixels)[1:]
    for found, expected in zip(maps, expected_maps, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-4)
    direction = torch.randn(24, generator=torch.Generator().manual_seed(1))
    feeds = dict(zip((output.name for output in session.get_outputs()[1:]), maps)) | {"direction": direction.numpy()}
    (found,) = open_session(tmp_path / SALIENCY, exact=True).run(None, feeds)
    expected = grad_cam(tower, direction, *expected_maps)
    np.testing.assert_allclose(found, expected, atol=1e-4 * float(expected.max()), rtol=0)


@pytest.mark.parametrize(("length", "masked"), [(None, True), (None, False), (32, True), (32, False)])
def test_the_text_graph_is_told_what_it_knows(length, masked, folder, tmp_path):
    source, *_, text = folder(resnet, length, masked)
    pair = open_source(str(source))
    assert (pair.context_length, pair.pad_id) == ((32, 0) if length else (77, None))
    pair.export(tmp_path)
    session = open_session(tmp_path / TEXT)
    names = [graph_input.name for graph_input in session.get_inputs()]
    assert names == ["input_ids", "attention_mask"][: 1 + masked]
    for prompt, ids in zip(PROMPTS, token_ids(pair, tmp_path / TOKENIZER)):
        mask = (np.arange(ids.shape[1]) <= int(np.argmax(ids[0] == 1)))[None].astype(np.int64)
        feeds = {"input_ids": ids, "attention_mask": mask}
        (found,) = session.run(None, {name: feeds[name] for name in names})
        expected = text(torch.tensor(ids), torch.tensor(mask) if masked else None)
        np.testing.assert_allclose(found, functional.normalize(expected, dim=-1).detach(), atol=1e-5)
        np.testing.assert_allclose(pair.read(prompt), found[0], atol=1e-5)


@pytest.mark.parametrize("missing", ["text_model.onnx", "vision_model.onnx", "tokenizer.json"])
def test_a_missing_file(missing, folder):
    source, *_ = folder(resnet)
    (source / missing).unlink()
    with pytest.raises(ModelError, match="has no .*" + missing):
        open_source(str(source))


def test_a_damaged_graph(folder):
    source, *_ = folder(resnet)
    (source / "vision_model.onnx").write_bytes(b"noise")
    with pytest.raises(ModelError, match="cannot be loaded"):
        open_source(str(source))


def test_graphs_in_int8_are_refused(folder, tmp_path):
    from onnxruntime.quantization import quantize_dynamic

    source, *_ = folder(vit)
    quantize_dynamic(source / "vision_model.onnx", source / "image.onnx")
    with pytest.raises(ModelError, match="MatMulInteger.*give a float32 graph"):
        open_source(str(source)).export(tmp_path)
