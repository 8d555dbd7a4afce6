"""What each region of a rendered scene truly shows: the truth that the manifest's relevance is fitted to."""

import numpy as np

from tools.assets.catalog import Entry
from tools.train.features import SHOWN, Features
from tools.train.words import names


def presence(features: Features, entries: list[Entry], nouns: list[str], regions) -> np.ndarray:
    """(N, R, V) float32: 1 where a region truly shows something of that name, 0 where not, NaN where one cannot say."""
    width = features.presence.shape[2]
    truth = np.zeros((len(features.middle), len(regions), len(nouns)), np.float32)
    place = {name: i for i, name in enumerate(nouns)}
    for k, (scene, model) in enumerate(zip(features.scene, features.model)):
        columns = [place[name] for name in names(entries[model]) if name in place]
        for r, (a, b) in enumerate(regions):
            share = features.presence[k, :, round(a * width) : round(b * width)].mean(dtype=np.float32)
            if share > 2 * SHOWN[0] and features.visible[k] > SHOWN[1]:
                truth[scene, r, columns] = 1
            elif share > 0:
                truth[scene, r, columns] = np.where(truth[scene, r, columns] == 1, 1, np.nan)
    return truth
