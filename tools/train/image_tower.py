"""The image tower in PyTorch: EfficientNet-Lite0's trunk, a neck for detail, the head, and the head's Grad-CAM."""

from pathlib import Path

import torch
from efficientnet_lite_pytorch import EfficientNet
from torch import nn
from torch.nn import functional

MIDDLE, LAST, DEEP = 112, 320, 1280  # channels: of the trunk's middle map, of its last block, of its last layer
DETAIL = 256  # channels of the neck's map
STRIDE = 32  # px of the input a cell of the deep map spans; the middle and the detail map have cells of half that
_SPLIT = 11  # first block after the middle map


class Trunk(nn.Module):
    """ImageNet EfficientNet-Lite0 in two parts, cut at the last map whose cells span 16 px.

    H and W must be multiples of 32: then TensorFlow's asymmetric "same" padding is that of the 224 px it was made for.
    Batch norm keeps ImageNet's statistics in training, too.
    """

    def __init__(self, network: EfficientNet):
        super().__init__()
        self.network = network.eval()

    @classmethod
    def load(cls, path: Path) -> "Trunk":
        network = EfficientNet.from_name("efficientnet-lite0")
        network.load_state_dict(torch.load(path, map_location="cpu", weights_only=True))
        return cls(network)

    def classifier(self) -> tuple[torch.Tensor, torch.Tensor]:
        """ImageNet's weights (1000, 1280) and bias (1000,)."""
        return self.network._fc.weight.detach(), self.network._fc.bias.detach()

    def middle(self, image):
        """(B, 3, H, W) to (B, 112, H/16, W/16)."""
        x = functional.relu6(self.network._bn0(self.network._conv_stem(image)))
        for block in self.network._blocks[:_SPLIT]:
            x = block(x)
        return x

    def deep(self, middle):
        """The middle map to the last block's (B, 320, H/32, W/32) and the last layer's (B, 1280, H/32, W/32)."""
        last = middle
        for block in self.network._blocks[_SPLIT:]:
            last = block(last)
        return last, functional.relu6(self.network._bn1(self.network._conv_head(last)))

    def late(self) -> list[nn.Module]:
        """The parts after the middle map."""
        return [*self.network._blocks[_SPLIT:], self.network._conv_head, self.network._bn1]

    def train(self, mode: bool = True):
        return super().train(False)


class Neck(nn.Module):
    """What the last block knows, put where the middle map sees edges: (B, 256, H/16, W/16), as in a feature pyramid
    (Lin et al. 2017). The deep map alone has cells too coarse to point at a cup."""

    def __init__(self):
        super().__init__()
        self.last = nn.Conv2d(LAST, DETAIL, 1)
        self.middle = nn.Conv2d(MIDDLE, DETAIL, 1)
        self.around = nn.Conv2d(DETAIL, DETAIL, 3, padding=1, groups=DETAIL, bias=False)
        self.mix = nn.Conv2d(DETAIL, DETAIL, 1)

    def forward(self, middle, last):
        wide = functional.interpolate(self.last(last), scale_factor=2, mode="nearest")
        return functional.relu6(self.mix(self.around(functional.relu6(wide + self.middle(middle)))))


class Head(nn.Module):
    """Pooled features (N, 1280 + 256) to unit vectors (N, D) in the text tower's space: a sum of two branches.

    - *projection*: trained on renders against the locked text tower (LiT, Zhai et al. 2022);
    - *concepts*: ImageNet's class posterior, averaged over the text embeddings of the class names (ConSE, Norouzi et
      al. 2014), so that nouns that no render shows still work. It reads the deep features only.
    """

    def __init__(self, classifier: nn.Linear, concepts: torch.Tensor, share: float):
        super().__init__()
        self.projection = nn.Linear(DEEP + DETAIL, concepts.shape[1])
        self.classifier = classifier
        self.concepts = nn.Parameter(concepts, requires_grad=False)
        self.share = share  # weight of the concepts, 0..1

    def branches(self, pooled):
        """The projection, the concept and the class posterior of pooled features."""
        posterior = torch.softmax(self.classifier(pooled[..., :DEEP]), -1)
        return self.projection(pooled), posterior @ self.concepts, posterior

    def forward(self, pooled):
        projected, concept, _ = self.branches(pooled)
        return self.fuse(projected, concept)

    def fuse(self, projected, concept):
        """The two branches' vectors, each at its share, as one unit vector."""
        fused = (1 - self.share) * functional.normalize(projected, dim=-1)
        return functional.normalize(fused + self.share * functional.normalize(concept, dim=-1), dim=-1)

    def sensitivity(self, pooled, direction):
        """Gradient of ``forward(pooled) . direction``, both (N, …), with respect to ``pooled``, written out.

        From the last operation to the first, so that it runs without autograd and can itself be trained.
        """
        projected, concept, posterior = self.branches(pooled)
        fused = (1 - self.share) * _unit(projected) + self.share * _unit(concept)
        at_fused = _through_norm(fused, direction)
        at_projected = (1 - self.share) * _through_norm(projected, at_fused)
        at_posterior = (self.share * _through_norm(concept, at_fused)) @ self.concepts.T
        at_logits = posterior * (at_posterior - (posterior * at_posterior).sum(-1, keepdim=True))
        weights = at_projected @ self.projection.weight
        deep = weights[..., :DEEP] + at_logits @ self.classifier.weight
        return torch.cat([deep, weights[..., DEEP:]], -1)


class ImageTower(nn.Module):
    """(1, 3, H, W) to the unit vectors (R, D) of picture and regions, and the deep and the detail map."""

    def __init__(self, trunk: Trunk, neck: Neck, head: Head, regions):
        super().__init__()
        self.trunk, self.neck, self.head, self.regions = trunk, neck, head, regions

    def forward(self, image):
        deep, detail = self.maps(self.trunk.middle(image))
        return self.head(pool(deep, detail, self.regions)[0]), deep, detail

    def maps(self, middle):
        """The deep map (B, 1280, h, w) and the detail map (B, 256, 2h, 2w) of a middle map (B, 112, 2h, 2w)."""
        last, deep = self.trunk.deep(middle)
        return deep, self.neck(middle, last)


def pool(deep, detail, regions):
    """Both maps to their means over each region's columns, (B, R, 1280 + 256). Edges must fall between deep cells."""
    width = int(deep.shape[3])
    columns = [(round(a * width), round(b * width)) for a, b in regions]
    parts = [(deep[..., a:b].mean((2, 3)), detail[..., 2 * a : 2 * b].mean((2, 3))) for a, b in columns]
    return torch.stack([torch.cat(part, 1) for part in parts], 1)


def grad_cam(head: Head, deep, detail, direction):
    """Grad-CAM (B, 2h, 2w), before its ReLU, of each picture's whole vector dotted with ``direction`` (B, D).

    Pooling gives every cell the same gradient, J^T direction / cells, so the channel weights of Selvaraju et al. 2017
    are J^T direction; the constant is left out. The layer is the deep map enlarged to the detail map's cells, beside
    the detail map. Enlarging bilinearly by two keeps the mean, and commutes with the sum over channels.
    """
    weights = head.sensitivity(torch.cat([deep.mean((2, 3)), detail.mean((2, 3))], 1), direction)[:, None]
    coarse = (weights[..., :DEEP] @ deep.flatten(2)).unflatten(2, deep.shape[2:])
    fine = (weights[..., DEEP:] @ detail.flatten(2)).unflatten(2, detail.shape[2:])
    return (functional.interpolate(coarse, scale_factor=2, mode="bilinear", align_corners=False) + fine)[:, 0]


class Front(nn.Module):
    """ImageNet's network as it came: (1, 3, H, W) to the middle map and the class logits (R, 1000) of each region."""

    def __init__(self, trunk: Trunk, classifier: nn.Linear, regions):
        super().__init__()
        self.trunk, self.classifier, self.regions = trunk, classifier, regions

    def forward(self, image):
        middle = self.trunk.middle(image)
        deep = self.trunk.deep(middle)[1]
        return middle, self.classifier(pool(deep, deep[:, :0], self.regions)[0])


class Saliency(nn.Module):
    """Grad-CAM as a graph: ``deep``, ``detail`` and ``direction`` (D,) to (2h, 2w)."""

    def __init__(self, head: Head):
        super().__init__()
        self.head = head

    def forward(self, deep, detail, direction):
        return torch.relu(grad_cam(self.head, deep, detail, direction[None])[0])


def _norm(x):
    return (x * x).sum(-1, keepdim=True).sqrt()


def _unit(x):
    return x / _norm(x)


def _through_norm(x, gradient):
    """Gradient with respect to ``x`` of a loss whose gradient with respect to ``x / |x|`` is given."""
    unit = _unit(x)
    return (gradient - (gradient * unit).sum(-1, keepdim=True) * unit) / _norm(x)
