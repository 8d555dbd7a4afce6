"""With the import extra only: a toy pair all the way to a model that the robot's encoder loads."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")
pytest.importorskip("safetensors")

from torch import nn  # noqa: E402

from edge.perception.encoder import Encoder  # noqa: E402
from edge.perception.prompts import Target  # noqa: E402
from models.manifest import Manifest, ModelError, folders, resolve  # noqa: E402
from tools.models import importing  # noqa: E402
from tools.models.clip_tokenizer import tokenizer_json  # noqa: E402
from tools.models.export import export_graph, export_text  # noqa: E402
from tools.models.grad_cam import export_saliency  # noqa: E402
from tools.models.pair import IMAGE, SALIENCY, TEXT, TOKENIZER, Pair  # noqa: E402
from tools.models.tower import Tower  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")

LETTERS = "abcdefghijklmnopqrstuvwxyz0123456789,!"


class Picture(nn.Module):
    def __init__(self):
        super().__init__()
        self.convolution, self.pool, self.head = nn.Conv2d(3, 16, 8, 8), nn.AdaptiveAvgPool2d(1), nn.Linear(16, 8)

    def forward(self, image):
        return self.head(self.pool(torch.relu(self.convolution(image))).flatten(1))


class Prompt(nn.Module):
    def __init__(self):
        super().__init__()
        self.letters, self.head = nn.Embedding(2 * len(LETTERS) + 2, 16), nn.Linear(16, 8)

    def forward(self, ids):
        return nn.functional.normalize(self.head(self.letters(ids).mean(1)), dim=-1)


@pytest.fixture
def pair():
    torch.manual_seed(0)
    picture, prompt = Picture().eval().requires_grad_(False), Prompt().eval().requires_grad_(False)
    pieces = [piece for letter in LETTERS for piece in (letter, f"{letter}</w>")]
    vocabulary = {token: i for i, token in enumerate(["<start>", "<end>", *pieces])}
    words = tokenizer_json(vocabulary, [], "<start>", "<end>")

    def export(folder):
        tower = Tower(picture, picture, picture.pool, (32, 40))
        export_graph(tower, (torch.zeros(1, 3, 32, 40),), folder / IMAGE, ["image"], ["vectors", *tower.names])
        export_saliency(tower, folder / SALIENCY)
        export_text(prompt, torch.ones(1, 4, dtype=torch.int64), folder / TEXT, fixed=False)
        (folder / TOKENIZER).write_text(words)

    def read(text):
        from tokenizers import Tokenizer

        return prompt(torch.tensor([Tokenizer.from_str(words).encode(text).ids]))[0].numpy()

    def see(pixels):
        return nn.functional.normalize(picture(torch.tensor(pixels)), dim=-1)[0].numpy()

    return Pair(
        source="a toy", licence="", kind="CNN", height=32, width=40, mean=(0.5,) * 3, std=(0.5,) * 3, logit_scale=50.0,
        context_length=200, pad_id=None, export=export, see=see, read=read,
    )  # fmt: skip


@pytest.fixture(autouse=True)
def quickly(monkeypatch):
    """Fewer homes; and toys run too briefly to be timed."""
    monkeypatch.setattr(importing.quantization, "SLOWEST", np.inf)
    monkeypatch.setattr(importing, "PARITY", 3)
    monkeypatch.setattr(importing, "RANGES", 3)
    monkeypatch.setattr(importing, "MEASURED", range(20, 21))
    monkeypatch.setattr(importing.homes, "RELEVANCE", range(106, 107))
    monkeypatch.setattr(importing.homes, "VIEWS", 10)


def test_a_model_that_the_robot_loads(pair, shelf):
    lines = []
    manifest = importing.import_pair(pair, "mine", lines.append)
    assert manifest.folder == resolve("mine") and [path.name for path in shelf.iterdir()] == ["mine"]
    assert manifest.source == "a toy" and manifest.dim == 8 and manifest.logit_scale == 50.0
    assert manifest.measured["homes"] == 1 and manifest.measured["image_ms"] > 0
    encoder = Encoder.load("mine")
    rgb = np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    view = encoder.encode_image(rgb)
    assert view.vectors.shape == (1, 8) and [features.shape for features in view.features] == [(16, 4, 5)]
    assert encoder.saliency(view, Target.of("chair", encoder).direction).shape == (4, 5)
    card = (manifest.folder / "MODEL_CARD.md").read_text()
    for words in ("# mine", manifest.digest, "a toy", "unknown: ask the source", "32 x 40 px", "stretched"):
        assert words in card
    assert any(line.startswith("image: int8") for line in lines)


def test_graphs_that_say_something_else_are_refused(pair, shelf):
    wrong = Pair(**(vars(pair) | {"see": lambda pixels: np.eye(8, dtype=np.float32)[0]}))
    with pytest.raises(ModelError, match="differ from the source by"):
        importing.import_pair(wrong, "mine")
    assert "mine" not in folders() and list(shelf.iterdir()) == []


def test_a_tower_that_cannot_be_exported(pair, shelf):
    def export(folder):
        export_graph(nn.CTCLoss(), (torch.zeros(5, 1, 3),) * 2, folder / IMAGE, ["image"], ["vectors"])

    with pytest.raises(ModelError, match="a toy cannot be exported: "):
        importing.import_pair(Pair(**(vars(pair) | {"export": export})), "mine")
    assert list(shelf.iterdir()) == []


def test_a_tower_that_int8_spoils_stays_in_float32(pair, shelf, monkeypatch):
    monkeypatch.setattr(importing.quantization, "LEAST", 1.1)
    importing.import_pair(pair, "mine")
    manifest = Manifest.load(resolve("mine"))
    assert manifest.measured["text_cosine"] == 1.0
    assert "| text | float32 |" in (manifest.folder / "MODEL_CARD.md").read_text()
