"""The vision-language encoder pair: pictures and prompts to unit vectors of one space, and where in the picture."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from edge.camera import CameraModel
from edge.memory.prompts import PromptMemory
from edge.perception.preprocess import preprocess
from edge.perception.session import open_session
from edge.perception.text import TextTower
from models.manifest import Manifest, ModelError, resolve


@dataclass(frozen=True)
class View:
    """What one picture says.

    ``vectors`` (R, D) float32 unit rows: the whole picture, then its regions from left to right;
    ``bearings`` (R,) rad: mid-angle of each region from the optical axis, left positive;
    ``features``: the spatial maps, (C, h, w) float32 each, that the model's saliency graph asks for;
    ``window`` (left, top, right, bottom) px: the part of the picture that was looked at, None for all of it.
    """

    vectors: np.ndarray
    bearings: np.ndarray
    features: tuple[np.ndarray, ...]
    window: tuple[int, int, int, int] | None = None


class Encoder:
    """Runs the graphs of one manifest."""

    def __init__(self, manifest: Manifest, text: bool = True, threads: int = 1):
        self._manifest = manifest
        self._image = open_session(manifest.folder / manifest.image.graph, threads, frequent=True)
        # In RAM only: what is measured with an encoder must not come from what another process left in a file.
        self._text = PromptMemory(TextTower(manifest, threads).encode, manifest.digest, manifest.dim) if text else None
        self._threads = threads
        self._maps = [output.name for output in self._image.get_outputs()[1:]]
        self._saliency = None

    @classmethod
    def load(cls, folder: str | Path | None = None, text: bool = True, threads: int = 1) -> "Encoder":
        """The encoder in ``folder`` (a path or a name; None is the shipped one), verified against its sha256 sums.

        ``text=False`` leaves out tokenizer and text tower (the host encodes prompts then); else the first prompt opens
        them.

        Raises:
            ModelError: the folder or one of its files is missing or damaged.
        """
        manifest = Manifest.load(resolve(folder) if folder is not None else resolve())
        manifest.verify(text)
        return cls(manifest, text, threads)

    @property
    def name(self) -> str:
        return self._manifest.name

    @property
    def digest(self) -> str:
        return self._manifest.digest

    @property
    def dim(self) -> int:
        return self._manifest.dim

    @property
    def logit_scale(self) -> float:
        """Scale of the two-prompt softmax ([V] Eq. 2)."""
        return self._manifest.logit_scale

    def relevance(self, cosine):
        """Cosine(s) of a picture vector and a prompt to relevance in [0, 1], by the manifest's calibration."""
        return self._manifest.relevance(cosine)

    def confidence(self, seen: float, remembered: float) -> float:
        """Probability that a claim is true, from the scores of what is in view and of what the memory holds."""
        return self._manifest.confidence(seen, remembered)

    def encode_image(self, rgb: np.ndarray, hfov: float = CameraModel.hfov, window=None) -> View:
        """One pass of the image tower over RGB ``(H, W, 3)`` uint8 from a camera with ``hfov`` [rad].

        ``window`` (left, top, right, bottom) px looks at that part only, enlarged: what is small in the whole picture
        is not in a part of it.

        Raises:
            ValueError: not a picture.
        """
        left, top, right, bottom = window or (0, 0, rgb.shape[1], rgb.shape[0])
        part = rgb[top:bottom, left:right]
        vectors, *maps = self._image.run(None, {"image": preprocess(part, self._manifest.image)})
        middle = np.array([(a + b) / 2 for a, b in self._manifest.image.regions])
        bearings = column_bearings(left + middle * (right - left), rgb.shape[1], hfov)
        return View(_finite_unit(vectors), bearings, tuple(features[0] for features in maps), window)

    def encode_text(self, texts: list[str]) -> np.ndarray:
        """Prompts to ``(N, D)`` float32 unit rows.

        Raises:
            ModelError: this encoder was loaded without its text tower.
        """
        if self._text is None:
            raise ModelError("This encoder was loaded without its text tower; load it with text=True or ask the host.")
        return self._text.encode(texts)

    def saliency(self, view: View, direction: np.ndarray) -> np.ndarray:
        """Grad-CAM ``(h, w)`` float32 >= 0 of the view's whole-picture vector dotted with ``direction`` (D,).

        Without autograd (Selvaraju et al. 2017, used as in [V] Sec. III-C): the model's own saliency graph evaluates it
        from the maps that its image graph gives beside the vectors. The shipped model's is a closed form: after average
        pooling the gradient is the same in every cell, so the map is ``ReLU(F . J(m)^T d)`` with m the pooled feature
        and J the Jacobian of the head there. An imported model's is the traced backward pass of what follows its maps.
        """
        if self._saliency is None:
            graph = self._manifest.folder / self._manifest.image.saliency
            self._saliency = open_session(graph, self._threads, exact=True)
        feeds = {name: features[None] for name, features in zip(self._maps, view.features)}
        feeds["direction"] = np.asarray(direction, np.float32)
        return np.nan_to_num(self._saliency.run(None, feeds)[0], posinf=0.0)


def column_bearings(column, width: int, hfov: float):
    """Bearing(s) [rad], left positive, of edges between pixel columns, counted from the left of ``width`` columns."""
    return np.arctan((1 - 2 * np.asarray(column) / width) * np.tan(hfov / 2))


def _finite_unit(vectors: np.ndarray) -> np.ndarray:
    """Rows scaled to norm 1; a row that is not finite or is zero becomes the first axis, so that no search sees NaN."""
    vectors = np.where(np.isfinite(vectors).all(1, keepdims=True), vectors, 0).astype(np.float32)
    norms = np.linalg.norm(vectors, axis=1, keepdims=True)
    fallback = np.eye(1, vectors.shape[1], dtype=np.float32)
    return np.where(norms > 1e-6, vectors / np.maximum(norms, 1e-6), fallback)
