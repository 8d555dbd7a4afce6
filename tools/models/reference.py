"""``reference.npz`` of a model folder: a few pictures and prompts, and what the towers in float32 make of them."""

from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import cv2
import numpy as np

from edge.perception.encoder import Encoder
from models.manifest import ModelError

NAME = "reference.npz"
_QUALITY = 90  # of the JPEGs; the vectors are of the decoded pictures


@dataclass(frozen=True)
class Reference:
    """``jpegs`` decode to pictures of any size; ``image`` (P, R, D) and ``text`` (N, D) are unit float32 rows."""

    jpegs: list[bytes]
    image: np.ndarray
    prompts: list[str]
    text: np.ndarray

    @classmethod
    def load(cls, folder: Path) -> "Reference | None":
        """That of the model in ``folder``; None if it has none.

        Raises:
            ModelError: it cannot be read.
        """
        path = Path(folder) / NAME
        if not path.exists():
            return None
        try:
            with np.load(path) as file:
                ends = np.cumsum(file["lengths"])[:-1]
                jpegs = [part.tobytes() for part in np.split(file["jpegs"], ends)]
                vectors = (file["image"].astype(np.float32), file["text"].astype(np.float32))
                return cls(jpegs, vectors[0], [str(prompt) for prompt in file["prompts"]], vectors[1])
        except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
            raise ModelError(f"{path} cannot be read ({error}); make or fetch the model again.") from None

    def save(self, folder: Path) -> None:
        """Write it into a model's folder; half precision moves a cosine by less than 1e-5."""
        np.savez_compressed(
            Path(folder) / NAME,
            jpegs=np.frombuffer(b"".join(self.jpegs), np.uint8),
            lengths=np.array([len(jpeg) for jpeg in self.jpegs]),
            image=self.image.astype(np.float16),
            prompts=np.array(self.prompts),
            text=self.text.astype(np.float16),
        )

    def pictures(self) -> list[np.ndarray]:
        """RGB ``(H, W, 3)`` uint8."""
        return [decode(jpeg) for jpeg in self.jpegs]


def encode(rgb: np.ndarray) -> bytes:
    """RGB ``(H, W, 3)`` uint8 as JPEG."""
    bgr = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1].tobytes()


def decode(jpeg: bytes) -> np.ndarray:
    """JPEG as RGB ``(H, W, 3)`` uint8."""
    return cv2.cvtColor(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def parity(encoder: Encoder, reference: Reference) -> dict[str, float]:
    """Median and least cosine of whole-picture vectors, and median cosine of prompts, to those in float32."""
    pictures = np.array([encoder.encode_image(rgb).vectors[0] for rgb in reference.pictures()])
    image = (pictures * _unit(reference.image[:, 0])).sum(1)
    text = (encoder.encode_text(reference.prompts) * _unit(reference.text)).sum(1)
    return {
        "image_parity": round(float(np.median(image)), 4),
        "image_parity_min": round(float(image.min()), 4),
        "text_parity": round(float(np.median(text)), 4),
    }


def _unit(rows: np.ndarray) -> np.ndarray:
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)
