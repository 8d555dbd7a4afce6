"""How good a head is on the validation models: naming close-ups, and ranking views as the memory does."""

from dataclasses import dataclass

import numpy as np
import torch

from tools.assets.catalog import Entry
from tools.train.features import CHUNK, SHOWN, STEP, Features
from tools.train.image_tower import Head
from tools.train.words import names, noun

VIEWS = 120  # a query ranks this many views, as in a home


@dataclass(frozen=True)
class Score:
    """Shares of 1. ``top1``/``top5``: close-ups whose noun is first / among five; ``first``/``within10``: queries for
    which a view that truly shows the object is first / within the first ten of 120."""

    top1: float
    top5: float
    first: float
    within10: float


def pooled_regions(features: Features, regions) -> torch.Tensor:
    """(N, R, C) mean features of each region."""
    width = features.maps.shape[2]
    columns = [(round(a * width), round(b * width)) for a, b in regions]
    means = [features.maps[:, :, a:b].mean((1, 2), dtype=np.float32) * STEP for a, b in columns]
    return torch.tensor(np.stack(means, 1))


def validate(
    head: Head, features: Features, pooled: torch.Tensor, entries: list[Entry], directions: dict[str, np.ndarray],
    seen: set[str] | None = None, draws: int = 12,
) -> Score:  # fmt: skip
    """``directions[noun]`` is t_obj - t_else; with ``seen`` only those nouns are asked for (all still compete)."""
    with torch.no_grad():
        vectors = head(pooled).numpy()
    nouns = sorted(directions)
    table = np.stack([directions[name] for name in nouns])
    place = {name: i for i, name in enumerate(nouns)}
    called = {i: {place[n] for n in names(entries[i]) if n in place} for i in set(features.model.tolist())}
    asked = set(nouns) if seen is None else seen
    first, five = _naming(features, vectors, table, entries, called, place, asked)
    ranked = _ranking(features, vectors, table, called, [place[name] for name in asked], draws)
    return Score(first, five, *ranked)


def _naming(features, vectors, table, entries, called, place, asked) -> tuple[float, float]:
    hits = []
    for scene, model in zip(features.scene, features.model):
        if scene % CHUNK % 20 < 8 and noun(entries[model]) in asked:  # a close-up
            logits = vectors[scene, 0] @ table.T
            # Names that are right too (tags) do not count against the noun.
            logits[list(called[int(model)] - {place[noun(entries[model])]})] = -np.inf
            hits.append(int((logits > logits[place[noun(entries[model])]]).sum()))
    return float(np.mean(np.array(hits) < 1)), float(np.mean(np.array(hits) < 5))


def _ranking(features, vectors, table, called, asked, draws) -> tuple[float, float]:
    share = features.presence.mean((1, 2), dtype=np.float32)
    shows = np.zeros((len(vectors), len(table)), bool)
    for scene, model, part, visible in zip(features.scene, features.model, share, features.visible):
        if part > SHOWN[0] and visible > SHOWN[1]:
            shows[scene, list(called[int(model)])] = True
    close_up = np.arange(len(vectors)) % CHUNK % 20 < 8
    scores = (vectors @ table.T).max(1)
    rng = np.random.default_rng(0)
    ranks = []
    for _ in range(draws):
        views = rng.choice(np.flatnonzero(~close_up), VIEWS, replace=False)
        for name in asked:
            right = shows[views, name]
            if right.any():
                ranks.append(int((scores[views, name] > scores[views, name][right].max()).sum()))
    return float(np.mean(np.array(ranks) < 1)), float(np.mean(np.array(ranks) < 10))
