"""Stage ``train``: fit the head's projection on the frozen trunk's features against the locked text tower (LiT)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch.nn import functional

from tools.assets.catalog import Entry
from tools.train.features import STEP, Features
from tools.train.image_tower import Head
from tools.train.words import NOTHING, TEMPLATES, names


@dataclass(frozen=True)
class TrainConfig:
    """How the head is trained; chosen on the validation models."""

    windows: int = 6  # a scene
    steps: int = 1200
    batch: int = 384  # windows
    rate: float = 1e-3  # AdamW's, cosine to zero
    decay: float = 0.05  # weight decay
    dropout: float = 0.4  # of pooled features
    scale: float = 20.0  # logits per unit of cosine difference: the two-prompt softmax's scale at run time too
    seen: float = 0.008  # share of a region that an object must cover to be named
    hidden: float = 0.3  # an object less visible than this share is neither named nor denied
    synonym: float = 0.65  # names closer than this cosine to a named one are not denied
    seed: int = 0


class Vocabulary:
    """All names of the training models, their text vectors and who may be called what."""

    def __init__(self, entries: list[Entry], encode: Callable[[list[str]], np.ndarray]):
        called = [names(entry) for entry in entries]
        self.names = sorted({name for group in called for name in group})
        place = {name: i for i, name in enumerate(self.names)}
        self.called = np.zeros((len(entries), len(self.names)), bool)
        for row, group in enumerate(called):
            self.called[row, [place[name] for name in group]] = True
        nothing = encode([NOTHING])[0]
        texts = np.stack([encode([template.format(name) for name in self.names]) for template in TEMPLATES])
        self.directions = torch.tensor(texts - nothing)  # (templates, V, D), t_obj - t_else of [V] Eq. 2
        bare = texts[1]
        self.cosines = bare @ bare.T

    def truth(self, named: np.ndarray, doubtful: np.ndarray, synonym: float) -> tuple[torch.Tensor, torch.Tensor]:
        """For regions with ``named`` and ``doubtful`` models (B, M): names that hold and that may be denied."""
        positive = (named.astype(np.float32) @ self.called.astype(np.float32)) > 0
        close = (positive.astype(np.float32) @ (self.cosines > synonym).astype(np.float32)) > 0
        maybe = (doubtful.astype(np.float32) @ self.called.astype(np.float32)) > 0
        return torch.tensor(positive), torch.tensor(~(positive | close | maybe))


@dataclass(frozen=True)
class Samples:
    """S windows: ``pooled`` (S, C) float32, and (S, V) bool the names that hold and those that may be denied."""

    pooled: torch.Tensor
    positive: torch.Tensor
    negative: torch.Tensor

    def with_more(self, other: "Samples") -> "Samples":
        """Both, one after the other."""
        pairs = zip((self.pooled, self.positive, self.negative), (other.pooled, other.positive, other.negative))
        return Samples(*(torch.cat(pair) for pair in pairs))


def sample(features: Features, vocabulary: Vocabulary, config: TrainConfig) -> Samples:
    """``config.windows`` windows of each scene with their truth."""
    rng = np.random.default_rng(config.seed)
    sightings = _sightings(features)
    parts = []
    for scene in range(len(features.maps)):
        windows = _windows(rng, config.windows, features.maps.shape[1:3])
        chosen = np.full(len(windows), scene)
        named, doubtful = _named(features, sightings, chosen, windows, vocabulary, config)
        pooled = pool_windows(features.maps[chosen], windows)
        parts.append((pooled, *vocabulary.truth(named, doubtful, config.synonym)))
    return Samples(*(torch.cat(part) for part in zip(*parts)))


def train(head: Head, samples: Samples, vocabulary: Vocabulary, config: TrainConfig) -> None:
    """Fit ``head.projection`` in place. The loss is on the fused vector, so the projection learns what is missing."""
    rng = np.random.default_rng(config.seed)
    torch.manual_seed(config.seed)
    with torch.no_grad():
        centre, spread = samples.pooled.mean(0), samples.pooled.std(0) + 1e-2
        posterior = [torch.softmax(head.classifier(part), -1) @ head.concepts for part in samples.pooled.split(4096)]
        concepts = functional.normalize(torch.cat(posterior), dim=-1)
    weight = torch.zeros(head.concepts.shape[1], len(centre)).normal_(0, len(centre) ** -0.5).requires_grad_()
    bias = torch.zeros(len(weight), requires_grad=True)
    groups = [{"params": [weight], "weight_decay": config.decay}, {"params": [bias], "weight_decay": 0.0}]
    optimizer = torch.optim.AdamW(groups, config.rate)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, config.steps)
    for _ in range(config.steps):
        chosen = torch.from_numpy(rng.integers(len(samples.pooled), size=config.batch))
        inputs = functional.dropout((samples.pooled[chosen] - centre) / spread, config.dropout)
        projected = functional.normalize(functional.linear(inputs, weight, bias), dim=-1)
        vectors = functional.normalize((1 - head.share) * projected + head.share * concepts[chosen], dim=-1)
        template = vocabulary.directions[rng.integers(len(vocabulary.directions))]
        loss = contrastive_loss(config.scale * vectors @ template.T, samples.positive[chosen], samples.negative[chosen])
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
    with torch.no_grad():  # fold the standardization of the inputs into the projection
        head.projection.weight.copy_(weight / spread)
        head.projection.bias.copy_(bias - (weight / spread) @ centre)


def contrastive_loss(logits, positive, negative):
    """Mean of three views of the same (B, V) table: is it there (sigmoid), what is it (rows), where is it (columns)."""
    sigmoid = functional.softplus(-logits)[positive].mean() + functional.softplus(logits)[negative].mean() * 4
    return sigmoid + _softmax_loss(logits, positive, negative) + _softmax_loss(logits.T, positive.T, negative.T)


def _softmax_loss(logits, positive, negative):
    """Mean over the positives of -log(p / (p + all negatives of the row)), so that positives do not compete."""
    against = torch.logsumexp(logits.masked_fill(~negative, -1e4), 1, keepdim=True)
    return functional.softplus(against - logits)[positive].mean()


def pool_windows(maps: np.ndarray, windows: np.ndarray) -> torch.Tensor:
    """Mean features (B, C) of ``maps`` (B, h, w, C) uint8 over ``windows`` (B, 4): rows r0:r1, columns c0:c1."""
    means = [m[r0:r1, c0:c1].mean((0, 1), dtype=np.float32) for m, (r0, r1, c0, c1) in zip(maps, windows)]
    return torch.tensor(np.stack(means)) * STEP


def _windows(rng: np.random.Generator, count: int, shape: tuple[int, int]) -> np.ndarray:
    """The regions of the run time (whole, thirds) for three in five, else any window of at least 3 x 3 cells."""
    height, width = shape
    windows = np.empty((count, 4), int)
    for row in windows:
        kind = rng.integers(5)
        if kind == 0:
            row[:] = 0, height, 0, width
        elif kind < 3:
            third = rng.integers(3)
            row[:] = 0, height, third * width // 3, (third + 1) * width // 3
        else:
            top, left = rng.integers(height - 2), rng.integers(width - 2)
            row[:] = top, rng.integers(top + 3, height + 1), left, rng.integers(left + 3, width + 1)
    return windows


def _sightings(features: Features) -> list[np.ndarray]:
    """Rows of the sightings of each scene."""
    order = np.argsort(features.scene, kind="stable")
    return np.split(order, np.searchsorted(features.scene[order], np.arange(1, len(features.maps))))


def _named(features, sightings, chosen, windows, vocabulary, config):
    """Models that a window shows, and models it shows too little of to say, each (B, M) bool."""
    named = np.zeros((len(chosen), len(vocabulary.called)), bool)
    doubtful = np.zeros_like(named)
    for row, (scene, (r0, r1, c0, c1)) in enumerate(zip(chosen, windows)):
        for k in sightings[scene]:
            share = features.presence[k, r0:r1, c0:c1].mean(dtype=np.float32)
            if share > config.seen and features.visible[k] > config.hidden:
                named[row, features.model[k]] = True
            elif share > 0:
                doubtful[row, features.model[k]] = True
    return named, doubtful & ~named

