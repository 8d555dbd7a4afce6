"""Self-attention written out, for graphs whose prompts vary in length."""

import torch
from torch import nn
from torch.nn import functional


class PlainAttention(nn.Module):
    """Stands in for an ``nn.MultiheadAttention`` over one sequence, with its weights.

    PyTorch's own writes the length of the traced prompt into the graph.
    """

    def __init__(self, attention: nn.MultiheadAttention):
        super().__init__()
        self.attention = attention

    def forward(self, query, key, value, need_weights: bool = False, attn_mask=None):
        """(1, T, W) rows, batch first, or (T, 1, W); ``attn_mask`` (T, T) is added. Gives the rows and None."""
        theirs = self.attention
        rows = query.reshape(1, -1, theirs.embed_dim)
        parts = functional.linear(rows, theirs.in_proj_weight, theirs.in_proj_bias).chunk(3, -1)
        split = [part.reshape(1, -1, theirs.num_heads, theirs.head_dim).transpose(1, 2) for part in parts]
        scores = split[0] @ split[1].transpose(2, 3) / theirs.head_dim**0.5
        if attn_mask is not None:
            scores = scores + attn_mask
        mixed = (torch.softmax(scores, -1) @ split[2]).transpose(1, 2).reshape(1, -1, theirs.embed_dim)
        return theirs.out_proj(mixed).reshape(query.shape), None


def write_out_attention(model: nn.Module) -> None:
    """Replace every ``nn.MultiheadAttention`` inside ``model``, in place."""
    for module in list(model.modules()):
        for name, child in list(module.named_children()):
            if isinstance(child, nn.MultiheadAttention):
                setattr(module, name, PlainAttention(child))
