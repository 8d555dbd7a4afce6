"""With the import extra only: what int8 keeps, and which version is taken."""

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")

from torch import nn  # noqa: E402

from edge.perception.session import open_session  # noqa: E402
from tools.models.export import export_graph, export_text  # noqa: E402
from tools.models.quantization import FLOAT32, choose, image_versions, text_versions  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")


def pick(versions):
    """``choose`` among [(name, cosine, milliseconds), ...]."""
    figures = {Path(name): rest for name, *rest in versions}
    return choose([(str(path), path) for path in figures], lambda p: figures[p][0], lambda p: figures[p][1]).name


@pytest.mark.parametrize(
    ("versions", "expected"),
    [
        ([("float", 1.0, 10.0), ("int8", 0.99, 5.0), ("other", 0.999, 1.0)], "int8"),
        ([("float", 1.0, 10.0), ("int8", 0.979, 5.0), ("other", 0.98, 5.0)], "other"),
        ([("float", 1.0, 10.0), ("int8", 0.99, 12.6)], "float"),
        ([("float", 1.0, 10.0), ("int8", float("nan"), 5.0)], "float"),
        ([("float", 1.0, 10.0)], "float"),
    ],
)
def test_the_first_that_is_true_and_quick_enough(versions, expected):
    assert pick(versions) == expected


class Convolutions(nn.Module):
    def __init__(self):
        super().__init__()
        widths = (3, 16, 16, 16, 16, 16, 32)
        layers = [nn.Sequential(nn.Conv2d(a, b, 3, padding=1), nn.ReLU()) for a, b in zip(widths, widths[1:])]
        self.layers, self.head = nn.Sequential(*layers), nn.Linear(32, 8)

    def forward(self, image):
        features = self.layers(image)
        return nn.functional.normalize(self.head(features.mean((2, 3))), dim=-1), features


class Words(nn.Module):
    def __init__(self):
        super().__init__()
        self.words, self.mix, self.head = nn.Embedding(5000, 32), nn.Linear(32, 64), nn.Linear(64, 8)

    def forward(self, ids):
        return nn.functional.normalize(self.head(torch.relu(self.mix(self.words(ids)))).mean(1), dim=-1)


def test_a_cnn_in_int8(tmp_path):
    torch.manual_seed(0)
    export_graph(Convolutions(), (torch.zeros(1, 3, 32, 32),), tmp_path / "i.onnx", ["image"], ["vectors", "features"])
    pictures = np.random.default_rng(0).normal(size=(8, 1, 3, 32, 32)).astype(np.float32)
    versions = dict(image_versions(tmp_path / "i.onnx", tmp_path, lambda: iter(pictures)))
    assert list(versions) == [FLOAT32, "int8", "int8 but for the stem", "int8 matrices, float32 convolutions"]
    plain = open_session(versions.pop(FLOAT32))
    sizes = []
    for path in versions.values():
        session = open_session(path)
        for picture in pictures:
            expected, _ = plain.run(None, {"image": picture})
            found, features = session.run(None, {"image": picture})
            assert features.shape == (1, 32, 32, 32) and float((found @ expected.T)[0, 0]) > 0.99
        data = path.with_name(path.name + ".data")
        sizes.append(data.stat().st_size)
    assert sizes[0] < sizes[1] < sizes[2]


def test_a_text_tower_in_int8(tmp_path):
    torch.manual_seed(0)
    export_text(Words(), torch.ones(1, 4, dtype=torch.int64), tmp_path / "t.onnx", fixed=False)
    versions = dict(text_versions(tmp_path / "t.onnx", tmp_path))
    assert list(versions) == [FLOAT32, "int8"]
    plain, small = (open_session(path) for path in versions.values())
    for length in (1, 4, 9):
        ids = np.random.default_rng(length).integers(0, 5000, (1, length))
        (expected,), (found,) = plain.run(None, {"input_ids": ids}), small.run(None, {"input_ids": ids})
        assert float((found @ expected.T)[0, 0]) > 0.99
    assert versions["int8"].with_name("text int8.onnx.data").stat().st_size < 0.3 * versions[FLOAT32].stat().st_size
