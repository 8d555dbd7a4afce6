"""Pictures of simulated homes, to set an imported pair's ranges and its sense of what a cosine means."""

import numpy as np

from edge.perception.encoder import Encoder
from edge.perception.prompts import contrast
from tools.logistic import logistic
from tools.train.homes import shoot

# Seeds of generated homes, apart from each other and from those that `vlpg eval encoder` measures in.
RANGES, PARITY, RELEVANCE = range(100, 104), range(104, 106), range(106, 112)
VIEWS = 40  # a home, for the relevance


def pictures(seeds: range, count: int) -> list[np.ndarray]:
    """``count`` views, (H, W, 3) uint8, from the homes together."""
    each = -(-count // len(seeds))
    return [shot.rgb for seed in seeds for shot in shoot(seed, each)[1]][:count]


def fit_relevance(encoder: Encoder, seeds: range, views: int) -> dict[str, float]:
    """Slope and offset from cosine to relevance: does a view truly show a thing of that name? ``views`` a home.

    Things that are in view, but too small or too hidden to count as shown, are left out.
    """
    cosines, truths = [], []
    for seed in seeds:
        names, shots = shoot(seed, views)
        nouns = sorted(set(names))
        texts = encoder.encode_text([contrast(noun.lower())[0] for noun in nouns])
        for shot in shots:
            row = texts @ encoder.encode_image(shot.rgb).vectors[0]
            in_view = {names[i] for i in np.unique(shot.instances) if i >= 0}
            shown = {name for name, there in zip(names, shot.shown) if there}
            known = [k for k, noun in enumerate(nouns) if noun in shown or noun not in in_view]
            cosines.extend(row[known])
            truths.extend(nouns[k] in shown for k in known)
    return scaled_logistic(np.array(cosines, float), np.array(truths))


def scaled_logistic(cosines: np.ndarray, truths: np.ndarray) -> dict[str, float]:
    """``logistic`` on standardized cosines: those of some pairs, SigLIP's say, keep within a few hundredths.

    Where higher cosines do not go with what is shown, as with untrained weights, every relevance is one half.
    """
    mean, spread = cosines.mean(), max(cosines.std(), 1e-6)
    slope, offset = logistic((cosines - mean) / spread, truths, balanced=True)
    if slope <= 0:
        return {"slope": 0.0, "offset": 0.0}
    return {"slope": round(slope / spread, 4), "offset": round(offset - slope * mean / spread, 4)}
