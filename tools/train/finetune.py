"""Stage ``train``: fit head and neck, and fine-tune the late blocks, against the locked text tower (LiT)."""

import itertools
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import nn
from torch.nn import functional
from torch.nn.utils import parametrize
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from tools.train import losses
from tools.train.batches import Batch, Batches
from tools.train.image_tower import ImageTower, grad_cam
from tools.train.vocabulary import Vocabulary


@dataclass(frozen=True)
class TrainConfig:
    """How the tower is trained; chosen on the validation models."""

    steps: int = 3400
    batch: int = 48  # scenes
    windows: int = 2  # a scene, beside the regions of the run time
    rate: float = 1e-3  # AdamW's, of head and neck; cosine to zero after a warm-up
    late_rate: float = 1e-4  # of the trunk's late blocks
    warm_up: int = 100  # steps
    decay: float = 0.05  # weight decay
    dropout: float = 0.4  # of pooled features
    scale: float = 20.0  # logits per unit of cosine difference, at run time too ([V] Eq. 2)
    synonym: float = 0.65  # names closer than this cosine to a named one are not denied
    pointing: float = 0.5  # weight of the dense term
    forgetting: float = 0.5  # weight of ImageNet's posterior
    average: float = 0.998  # of the weights, a step
    every: int = 100  # steps between checkpoints
    seed: int = 0


def train(tower: ImageTower, batches: Batches, vocabulary: Vocabulary, config: TrainConfig, checkpoint: Path) -> None:
    """Train ``tower`` in place; goes on from ``checkpoint`` if that exists, and removes it at the end.

    On a GPU if there is one; afterwards the tower is on the CPU again.
    """
    torch.manual_seed(config.seed)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    stream = (batch.to(device) for batch in batches)
    vocabulary.to(device)
    tower.to(device, memory_format=torch.channels_last)
    centre = _standardize(tower, itertools.islice(stream, 10))
    late = nn.ModuleList(tower.trunk.late()).requires_grad_(True)
    fresh = [*tower.neck.requires_grad_(True).parameters(), *tower.head.projection.requires_grad_(True).parameters()]
    groups = [{"params": fresh, "lr": config.rate}, {"params": [*late.parameters()], "lr": config.late_rate}]
    optimizer = torch.optim.AdamW(groups, weight_decay=config.decay)
    warm = torch.optim.lr_scheduler.LinearLR(optimizer, 0.05, 1.0, config.warm_up)
    cosine = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, config.steps - config.warm_up)
    schedule = torch.optim.lr_scheduler.SequentialLR(optimizer, [warm, cosine], [config.warm_up])
    average = AveragedModel(tower, multi_avg_fn=get_ema_multi_avg_fn(config.average))
    parts = {"tower": tower, "average": average, "optimizer": optimizer, "schedule": schedule}
    start = _resume(checkpoint, parts)
    for step in range(start, config.steps):
        terms = loss(tower, next(stream), vocabulary, config, centre)
        optimizer.zero_grad()
        sum(terms.values()).backward()
        nn.utils.clip_grad_norm_([p for group in groups for p in group["params"]], 5.0)
        optimizer.step()
        schedule.step()
        average.update_parameters(tower)
        if (step + 1) % config.every == 0:
            print(step + 1, {name: round(term.item(), 3) for name, term in terms.items()}, flush=True)
            torch.save({"step": step + 1} | {name: part.state_dict() for name, part in parts.items()}, checkpoint)
    tower.load_state_dict(average.module.state_dict())
    parametrize.remove_parametrizations(tower.head.projection, "weight")
    tower.requires_grad_(False).cpu()
    vocabulary.to(torch.device("cpu"))
    checkpoint.unlink(missing_ok=True)


def loss(tower: ImageTower, batch: Batch, vocabulary: Vocabulary, config: TrainConfig, centre) -> dict:
    """The three terms of one batch, weighted."""
    head = tower.head
    deep, detail = tower.maps(batch.middle.contiguous(memory_format=torch.channels_last))
    pooled = pool_windows(deep, detail, batch.windows)
    noisy = centre + functional.dropout(pooled - centre, config.dropout)
    _, concept, _ = head.branches(pooled)
    vectors = head.fuse(head.projection(noisy), concept).flatten(0, 1)
    template = vocabulary.directions[torch.randint(len(vocabulary.directions), ())]
    named, doubtful = batch.named.flatten(0, 1), batch.doubtful.flatten(0, 1)
    truth = vocabulary.truth(named, doubtful, config.synonym)
    regions = batch.logits.shape[1]
    return {
        "naming": losses.naming(config.scale * vectors @ template.T, *truth),
        "pointing": config.pointing * _pointing(head, deep, detail, batch, vocabulary, template),
        "forgetting": config.forgetting
        * losses.forgetting(head.classifier(pooled[:, :regions, : deep.shape[1]]), batch.logits),
    }


def pool_windows(deep, detail, windows):
    """Means of both maps over ``windows`` (B, W, h, w) of the deep map's cells, (B, W, 1280 + 256)."""
    fine = windows.repeat_interleave(2, 2).repeat_interleave(2, 3)
    parts = [
        torch.einsum("bchw,bnhw->bnc", features, masks) / masks.sum((2, 3))[..., None]
        for features, masks in ((deep, windows), (detail, fine))
    ]
    return torch.cat(parts, -1)


def _pointing(head, deep, detail, batch: Batch, vocabulary: Vocabulary, template):
    """The dense term: each thing by one of its names, and all in the picture that may be called that."""
    name = torch.multinomial(vocabulary.called[batch.model], 1)[:, 0]
    saliency = grad_cam(head, deep[batch.scene], detail[batch.scene], template[name])
    together = vocabulary.called[batch.shown][:, name] * (batch.shown_in[:, None] == batch.scene)  # (S, P)
    presence = torch.einsum("sp,shw->phw", together, batch.presence)
    return losses.pointing(saliency, presence.clamp(max=1))


def _standardize(tower: ImageTower, batches) -> torch.Tensor:
    """Let the projection be trained as if each pooled feature had variance one; returns the features' mean."""
    with torch.no_grad():
        pooled = [pool_windows(*tower.maps(batch.middle), batch.windows).flatten(0, 1) for batch in batches]
    pooled = torch.cat(pooled)
    scale = 1 / (pooled.std(0) + 1e-2)
    parametrize.register_parametrization(tower.head.projection, "weight", _Scaled(scale))
    return pooled.mean(0)


class _Scaled(nn.Module):
    def __init__(self, scale):
        super().__init__()
        self.register_buffer("scale", scale)

    def forward(self, weight):
        return weight * self.scale

    def right_inverse(self, weight):
        return weight / self.scale


def _resume(checkpoint: Path, parts: dict) -> int:
    if not checkpoint.exists():
        return 0
    saved = torch.load(checkpoint, map_location="cpu", weights_only=True)
    for name, part in parts.items():
        part.load_state_dict(saved[name])
    return saved["step"]
