"""The image tower in PyTorch: EfficientNet-Lite0's trunk, the head on its pooled features, and the head's Grad-CAM."""

from pathlib import Path

import torch
from efficientnet_lite_pytorch import EfficientNet
from torch import nn
from torch.nn import functional

CHANNELS = 1280  # of the trunk's last feature map
STRIDE = 32  # px of the input a cell of that map


class Trunk(nn.Module):
    """ImageNet EfficientNet-Lite0 up to the last feature map: (B, 3, H, W) to (B, 1280, H/32, W/32).

    H and W must be multiples of 32: then TensorFlow's asymmetric "same" padding is that of the 224 px it was made for.
    """

    def __init__(self, network: EfficientNet):
        super().__init__()
        self.network = network

    @classmethod
    def load(cls, path: Path) -> "Trunk":
        network = EfficientNet.from_name("efficientnet-lite0")
        network.load_state_dict(torch.load(path, map_location="cpu", weights_only=True))
        return cls(network.eval()).eval()

    def classifier(self) -> tuple[torch.Tensor, torch.Tensor]:
        """ImageNet's weights (1000, 1280) and bias (1000,)."""
        return self.network._fc.weight.detach(), self.network._fc.bias.detach()

    def forward(self, image):
        return self.network.extract_features(image)


class Head(nn.Module):
    """Pooled features (N, 1280) to unit vectors (N, D) in the text tower's space: a weighted sum of two branches.

    - *projection*: trained on renders against the locked text tower (LiT, Zhai et al. 2022);
    - *concepts*: ImageNet's class posterior, averaged over the text embeddings of the class names (ConSE, Norouzi et
      al. 2014), so that nouns that no render shows still work.
    """

    def __init__(self, classifier: nn.Linear, concepts: torch.Tensor, share: float):
        super().__init__()
        self.projection = nn.Linear(CHANNELS, concepts.shape[1])
        self.classifier = classifier
        self.concepts = nn.Parameter(concepts, requires_grad=False)
        self.share = share  # weight of the concepts, 0..1

    def branches(self, pooled):
        posterior = torch.softmax(self.classifier(pooled), -1)
        return self.projection(pooled), posterior @ self.concepts, posterior

    def forward(self, pooled):
        projected, concept, _ = self.branches(pooled)
        fused = (1 - self.share) * functional.normalize(projected, dim=-1)
        return functional.normalize(fused + self.share * functional.normalize(concept, dim=-1), dim=-1)


class ImageTower(nn.Module):
    """(1, 3, H, W) to the unit vectors (R, D) of picture and regions, and the feature map (1, C, h, w)."""

    def __init__(self, trunk: Trunk, head: Head, regions):
        super().__init__()
        self.trunk, self.head, self.regions = trunk, head, regions

    def forward(self, image):
        features = self.trunk(image)
        return self.head(pool(features, self.regions)[0]), features


def pool(features, regions):
    """(B, C, h, w) to the means over each region's columns, (B, R, C). Edges must fall between cells."""
    width = int(features.shape[3])
    columns = [(round(a * width), round(b * width)) for a, b in regions]
    return torch.stack([features[..., a:b].mean((2, 3)) for a, b in columns], 1)


class Saliency(nn.Module):
    """Grad-CAM of ``head(mean(F)) . direction`` without autograd: ReLU(F . J^T direction), (1, C, h, w) to (h, w).

    The gradient with respect to every cell is J^T direction / (h w), so the channel weights of Selvaraju et al. 2017
    are that vector; the constant 1 / (h w) is left out. J^T is written out, from the last operation to the first.
    """

    def __init__(self, head: Head):
        super().__init__()
        self.head = head

    def forward(self, features, direction):
        pooled = features.mean((0, 2, 3))
        projected, concept, posterior = self.head.branches(pooled)
        share = self.head.share
        fused = (1 - share) * projected / _norm(projected) + share * concept / _norm(concept)
        at_fused = _through_norm(fused, direction)
        at_projected = (1 - share) * _through_norm(projected, at_fused)
        at_posterior = self.head.concepts @ (share * _through_norm(concept, at_fused))
        at_logits = posterior * (at_posterior - (posterior * at_posterior).sum())
        weights = at_projected @ self.head.projection.weight + at_logits @ self.head.classifier.weight
        return torch.relu((features[0] * weights[:, None, None]).sum(0))


def _norm(x):
    return (x * x).sum().sqrt()


def _through_norm(x, gradient):
    """Gradient with respect to ``x`` of a loss whose gradient with respect to ``x / |x|`` is given."""
    unit = x / _norm(x)
    return (gradient - (gradient * unit).sum() * unit) / _norm(x)
