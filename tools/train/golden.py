"""What PyTorch says, kept small, so that the robot's side can be tested without PyTorch."""

from pathlib import Path

import numpy as np
import torch

from edge.perception.encoder import Encoder
from edge.perception.preprocess import preprocess
from models.manifest import Image
from tools.train.image_tower import ImageTower


def grad_cam(head, features: torch.Tensor, direction: torch.Tensor) -> torch.Tensor:
    """Grad-CAM (h, w) of ``head(mean(features)) . direction`` by autograd; ``features`` (1, C, h, w).

    Selvaraju et al. 2017: channel weights are the gradients averaged over the cells. Scaled by the number of cells, as
    the closed form leaves that factor out.
    """
    features = features.detach().requires_grad_()
    (head(features.mean((2, 3)))[0] @ direction).backward()
    weights = features.grad.mean((2, 3), keepdim=True) * features.shape[2] * features.shape[3]
    return torch.relu((weights * features.detach()).sum(1)[0])


def write_golden(tower: ImageTower, pictures: list[np.ndarray], image: Image, encoder: Encoder, path: Path) -> None:
    """``pictures`` with the float32 tower's vectors; of three also features, directions and Grad-CAM."""
    names = ("teddy bear", "chair", "refrigerator")
    prompts = encoder.encode_text([f"A photo of {name}" for name in names] + ["A photo of something else"])
    directions = prompts[:3] - prompts[3]
    vectors, kept, maps = [], [], []
    with torch.no_grad():
        for rgb in pictures:
            found, features = tower(torch.tensor(preprocess(rgb, image)))
            vectors.append(found.numpy())
            kept.append(features.half())
    for features, direction in zip(kept, directions):
        maps.append(grad_cam(tower.head, features.float(), torch.tensor(direction)).numpy())
    np.savez_compressed(
        path,
        pictures=np.stack(pictures),
        vectors=np.stack(vectors),
        features=np.concatenate([features.numpy() for features in kept[:3]]),
        directions=directions,
        saliency=np.stack(maps),
    )
