"""How good a head is on the validation models: naming close-ups, and ranking views as the memory does."""

from dataclasses import dataclass

import numpy as np
import torch

from tools.assets.catalog import Entry
from tools.train.features import SHOWN, Features, is_close_up
from tools.train.image_tower import ImageTower, grad_cam, pool
from tools.train.words import names, noun

VIEWS = 120  # a query ranks this many views, as in a home


@dataclass(frozen=True)
class Score:
    """Shares of 1. ``top1``/``top5``: close-ups whose noun is first / among five; ``first``/``within10``: queries for
    which a view that truly shows the object is first / within the first ten of 120; ``pointing``: things in view that
    the saliency's peak lies on."""

    top1: float
    top5: float
    first: float
    within10: float
    pointing: float


def validate(
    tower: ImageTower, features: Features, entries: list[Entry], directions: dict[str, np.ndarray], draws: int = 12
) -> tuple[Score, np.ndarray]:
    """The score and the scenes' vectors (N, R, D). ``directions[noun]`` is t_obj - t_else of every noun in them."""
    nouns = sorted(directions)
    table = np.stack([directions[name] for name in nouns])
    place = {name: i for i, name in enumerate(nouns)}
    called = {i: {place[n] for n in names(entries[i]) if n in place} for i in set(features.model.tolist())}
    vectors, pointing = _look(tower, features, entries, directions)
    first, five = _naming(features, vectors, table, entries, called, place)
    ranked = _ranking(features, vectors, table, called, list(place.values()), draws)
    return Score(first, five, *ranked, pointing), vectors


def _truly_shown(features: Features) -> np.ndarray:
    """(K,) which sightings are large and free enough that anyone would see the thing."""
    share = features.presence.mean((1, 2), dtype=np.float32)
    return (share > SHOWN[0]) & (features.visible > SHOWN[1])


def _look(tower, features, entries, directions, batch: int = 50):
    """Vectors (N, R, D) of all scenes, and the share of things truly shown that the saliency's peak lies on."""
    vectors, hits = [], []
    shown = _truly_shown(features)
    for start in range(0, len(features.middle), batch):
        with torch.no_grad():
            deep, detail = tower.maps(torch.from_numpy(features.middle[start : start + batch]).float())
            vectors.append(tower.head(pool(deep, detail, tower.regions)).numpy())
            mine = np.flatnonzero(shown & (features.scene >= start) & (features.scene < start + batch))
            if not len(mine):
                continue
            asked = torch.tensor(np.stack([directions[noun(entries[model])] for model in features.model[mine]]))
            scene = features.scene[mine] - start
            maps = grad_cam(tower.head, deep[scene], detail[scene], asked).flatten(1).numpy()
        peak = maps.argmax(1)
        hits.append(features.presence[mine].reshape(len(mine), -1)[np.arange(len(mine)), peak] > 0)
    return np.concatenate(vectors), float(np.concatenate(hits).mean())


def _naming(features, vectors, table, entries, called, place) -> tuple[float, float]:
    hits = []
    for scene, model in zip(features.scene, features.model):
        if is_close_up(scene):
            logits = vectors[scene, 0] @ table.T
            # Names that are right too (tags) do not count against the noun.
            logits[list(called[int(model)] - {place[noun(entries[model])]})] = -np.inf
            hits.append(int((logits > logits[place[noun(entries[model])]]).sum()))
    return float(np.mean(np.array(hits) < 1)), float(np.mean(np.array(hits) < 5))


def _ranking(features, vectors, table, called, asked, draws) -> tuple[float, float]:
    shows = np.zeros((len(vectors), len(table)), bool)
    for k in np.flatnonzero(_truly_shown(features)):
        shows[features.scene[k], list(called[int(features.model[k])])] = True
    close_up = is_close_up(np.arange(len(vectors)))
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
