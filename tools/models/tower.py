"""An image tower of any framework, cut at its last spatial map into a trunk and a tail."""

from collections.abc import Callable
from math import isqrt

import torch
from torch import nn
from torch.nn import functional


class Tower(nn.Module):
    """(1, 3, H, W) normalized pixels to the unit vector (1, D), then the maps at the cut.

    The cut is the input of one of the model's own modules, caught and replaced by hooks, so that no architecture has to
    be taken apart: the last stage's pooling of a CNN, the attention pool of a CLIP ResNet, the last block of a ViT.

    - A CNN's cut has one map, (1, C, h, w).
    - A ViT's has the patches' tokens as a map (1, C, h, w) and, if there are any, the class token and registers, which
      have no place in the picture, as another, (1, C, 1, n).
    """

    def __init__(self, model: nn.Module, encode: Callable, cut: nn.Module, size: tuple[int, int]):
        """``encode`` takes pixels to vectors with ``model``; ``size`` is (height, width) in px."""
        super().__init__()
        self.model, self.encode, self.size = model, encode, size
        self._cut = [cut]  # in a list: it is the model's own part already
        with torch.no_grad():
            image = torch.zeros(1, 3, *size)
            self._tokens = self._run(image)[1].dim() == 3
            vector, *maps = self(image)
        self.dim = int(vector.shape[1])
        self.names = ["patches", "others"][: len(maps)] if self._tokens else ["features"]
        self.shapes = [tuple(map(int, features.shape)) for features in maps]

    def forward(self, image):
        vector, features = self._run(image)
        return vector, *(_tokens_to_maps(features) if self._tokens else (features,))

    def tail(self, *maps):
        """The maps at the cut to the unit vector (1, D)."""
        features = _maps_to_tokens(maps) if self._tokens else maps[0]
        # The trunk runs over a black picture, for nothing; what it computes is not used and leaves the exported graph.
        return self._run(torch.zeros(1, 3, *self.size), features)[0]

    def _run(self, image, replacement=None):
        """The unit vector and the features at the cut, which ``replacement`` may replace."""
        caught = []

        def at_cut(module, arguments, keywords):
            caught.append(arguments[0] if arguments else next(iter(keywords.values())))
            if replacement is None:
                return None
            if arguments:
                return (replacement, *arguments[1:]), keywords
            return arguments, keywords | {next(iter(keywords)): replacement}

        hook = self._cut[0].register_forward_pre_hook(at_cut, with_kwargs=True)
        try:
            vector = functional.normalize(self.encode(image), dim=-1)
        finally:
            hook.remove()
        return vector, caught[0]


def _tokens_to_maps(tokens):
    """(1, n + side * side, C) to the maps (1, C, side, side) and, unless n is 0, (1, C, 1, n)."""
    count = int(tokens.shape[1])
    side = isqrt(count)
    columns = tokens.transpose(1, 2)
    extra = count - side * side
    patches = columns[:, :, extra:].unflatten(2, (side, side))
    return (patches, columns[:, :, None, :extra]) if extra else (patches,)


def _maps_to_tokens(maps):
    patches, *others = maps
    columns = torch.cat([features.flatten(2) for features in (*others, patches)], 2)
    return columns.transpose(1, 2)
