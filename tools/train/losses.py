"""What training minimizes: naming, pointing, and not forgetting ImageNet."""

import torch
from torch.nn import functional

_SHARPNESS = 2.0  # of the softmax over standardized saliency: its peak is then well above chance but not saturated
_SLOPE = 8.0  # of the sigmoid around half the peak, where the robot cuts its box


def naming(logits, positive, negative):
    """Mean of three views of the same (B, V) table: is it there (sigmoid), what is it (rows), where is it (columns)."""
    sigmoid = functional.softplus(-logits)[positive].mean() + functional.softplus(logits)[negative].mean() * 4
    return sigmoid + _softmax(logits, positive, negative) + _softmax(logits.T, positive.T, negative.T)


def _softmax(logits, positive, negative):
    """Mean over the positives of -log(p / (p + all negatives of the row)), so that positives do not compete."""
    against = torch.logsumexp(logits.masked_fill(~negative, -1e4), 1, keepdim=True)
    return functional.softplus(against - logits)[positive].mean()


def pointing(saliency, presence):
    """How badly maps (P, h, w) of signed saliency point at what covers ``presence`` (P, h, w) of each cell, in 0..1.

    The peak should lie on the object, and the cells above half the peak should be the object's.
    """
    flat, cover = saliency.flatten(1), presence.flatten(1)
    standard = (flat - flat.mean(1, keepdim=True)) / (flat.std(1, keepdim=True) + 1e-6)
    share = cover / cover.amax(1, keepdim=True)  # a cup fills no cell
    on_it = (torch.softmax(_SHARPNESS * standard, 1) * share).sum(1)
    level = torch.relu(flat) / (flat.amax(1, keepdim=True).detach().clamp(min=1e-6))
    wrong = functional.binary_cross_entropy_with_logits(_SLOPE * (level - 0.5), share, reduction="none")
    rest = 1 - share  # nothing, when the object fills the picture
    inside, outside = (wrong * share).sum(1) / share.sum(1), (wrong * rest).sum(1) / rest.sum(1).clamp(min=1)
    return -(on_it + 1e-6).log().mean() + (inside + outside).mean()


def forgetting(logits, before):
    """Mean divergence of class posteriors from what ImageNet's own network says, both as logits (…, 1000)."""
    return functional.kl_div(
        torch.log_softmax(logits, -1).flatten(0, -2),
        torch.log_softmax(before, -1).flatten(0, -2),
        log_target=True,
        reduction="batchmean",
    )
