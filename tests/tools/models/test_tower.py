"""With the import extra only; towers of real architectures are in test_grad_cam.py."""

import pytest

torch = pytest.importorskip("torch")

from torch import nn  # noqa: E402

from tools.models.tower import Tower  # noqa: E402


class Tokens(nn.Module):
    """A picture cut into 3 x 3 patches, ``extra`` tokens before them, and a block that keywords are passed to."""

    def __init__(self, extra):
        super().__init__()
        self.patches, self.block, self.head = nn.Conv2d(3, 8, 4, 4), Block(), nn.Linear(8, 5)
        self.extra = nn.Parameter(torch.randn(1, extra, 8))

    def forward(self, image):
        tokens = torch.cat([self.extra, self.patches(image).flatten(2).transpose(1, 2)], 1)
        return self.head(self.block(hidden=tokens, scale=2.0).mean(1))


class Block(nn.Module):
    def forward(self, hidden, scale):
        return torch.tanh(hidden * scale)


@pytest.mark.parametrize("extra", [0, 1, 5])
def test_patches_lie_where_they_are_in_the_picture(extra):
    torch.manual_seed(0)
    model = Tokens(extra).requires_grad_(False)
    tower = Tower(model, model, model.block, (12, 12))
    image = torch.randn(1, 3, 12, 12)
    vector, patches, *others = tower(image)
    torch.testing.assert_close(patches, model.patches(image))
    assert [o.shape for o in others] == ([(1, 8, 1, extra)] if extra else [])
    assert tower.names == ["patches", "others"][: 1 + bool(extra)] and tower.dim == 5
    torch.testing.assert_close(tower.tail(patches, *others), vector)
    assert vector.norm() == pytest.approx(1)


def test_hooks_do_not_stay():
    model = Tokens(1).requires_grad_(False)
    tower = Tower(model, model, model.block, (12, 12))
    tower.tail(*(torch.zeros(shape) for shape in tower.shapes))
    assert not model.block._forward_pre_hooks
