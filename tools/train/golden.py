"""What PyTorch says, kept small, so that the robot's side can be tested without PyTorch."""

from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

from edge.perception.encoder import Encoder
from edge.perception.preprocess import preprocess
from models.manifest import Image
from tools.train.image_tower import ImageTower


def autograd_cam(head, deep: torch.Tensor, detail: torch.Tensor, direction: torch.Tensor) -> torch.Tensor:
    """Grad-CAM (2h, 2w) by autograd of ``head(pooled maps) . direction``; maps (1, C, h, w) and (1, C', 2h, 2w).

    Selvaraju et al. 2017: channel weights are the gradients averaged over the cells of the layer, here the deep map
    enlarged beside the detail map. Scaled by the number of cells, as the closed form leaves that factor out.
    """
    large = functional.interpolate(deep, scale_factor=2, mode="bilinear", align_corners=False)
    features = torch.cat([large, detail], 1).detach().requires_grad_()
    (head(features.mean((2, 3)))[0] @ direction).backward()
    weights = features.grad.mean((2, 3), keepdim=True) * features.shape[2] * features.shape[3]
    return torch.relu((weights * features.detach()).sum(1)[0])


def write_golden(tower: ImageTower, pictures: list[np.ndarray], image: Image, encoder: Encoder, path: Path) -> None:
    """``pictures`` with the float32 tower's vectors; of three also both maps, directions and Grad-CAM."""
    names = ("teddy bear", "chair", "refrigerator")
    prompts = encoder.encode_text([f"A photo of {name}" for name in names] + ["A photo of something else"])
    directions = prompts[:3] - prompts[3]
    vectors, kept, saliency = [], [], []
    with torch.no_grad():
        for rgb in pictures:
            found, *maps = tower(torch.tensor(preprocess(rgb, image)))
            vectors.append(found.numpy())
            kept.append([features.half() for features in maps])
    for maps, direction in zip(kept, directions):
        maps = [features.float() for features in maps]
        saliency.append(autograd_cam(tower.head, *maps, torch.tensor(direction)).numpy())
    deep, detail = (np.concatenate([features.numpy() for features in maps]) for maps in zip(*kept[:3]))
    np.savez_compressed(
        path,
        pictures=np.stack(pictures),
        vectors=np.stack(vectors),
        deep=deep,
        detail=detail,
        directions=directions,
        saliency=np.stack(saliency),
    )


def write_preprocess_golden(pictures: list[np.ndarray], image: Image, path: Path) -> None:
    """What training saw of ``pictures`` (of any sizes): every 16th row and column of the tower's input."""
    seen = np.concatenate([preprocess(rgb, image) for rgb in pictures])[:, :, ::16, ::16]
    named = {f"picture{i}": rgb for i, rgb in enumerate(pictures)}
    np.savez_compressed(path, seen=seen, **named)


def odd_sizes() -> list[np.ndarray]:
    """RGB uint8 patches in sizes that shrink, enlarge, do both, and fit; and one picture of noise."""
    pictures = []
    for height, width in ((240, 320), (480, 640), (100, 150), (300, 150), (224, 288), (1, 1)):
        y, x, channel = np.ogrid[:height, :width, :3]
        pictures.append(((x // 5 * 37 + y // 7 * 59 + channel * 80) % 256).astype(np.uint8))
    return [*pictures, np.random.default_rng(0).integers(0, 256, (60, 80, 3), dtype=np.uint8)]
