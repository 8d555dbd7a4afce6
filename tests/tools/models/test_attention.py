"""With the import extra only: attention written out is PyTorch's."""

import pytest

torch = pytest.importorskip("torch")

from torch import nn  # noqa: E402

from tools.models.attention import PlainAttention, write_out_attention  # noqa: E402


@pytest.mark.parametrize("batch_first", [True, False])
@pytest.mark.parametrize("masked", [True, False])
def test_it_is_pytorchs(batch_first, masked):
    torch.manual_seed(0)
    theirs = nn.MultiheadAttention(24, 4, batch_first=batch_first).eval()
    ours = PlainAttention(theirs)
    for length in (1, 5, 9):
        x = torch.randn(1, length, 24) if batch_first else torch.randn(length, 1, 24)
        mask = torch.full((length, length), float("-inf")).triu(1) if masked else None
        expected, _ = theirs(x, x, x, need_weights=False, attn_mask=mask)
        torch.testing.assert_close(ours(x, x, x, need_weights=False, attn_mask=mask)[0], expected)


def test_every_one_is_replaced():
    layer = nn.TransformerEncoderLayer(24, 4)
    model = nn.Sequential(nn.Sequential(layer), nn.Linear(24, 24))
    write_out_attention(model)
    assert isinstance(layer.self_attn, PlainAttention)
