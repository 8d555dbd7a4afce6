"""``vlpg models verify``: are the files whole, and is the model here what its manifest says it is?"""

from dataclasses import dataclass

from models.manifest import Manifest
from tools.models.measure import measure

# int8 kernels of other processors round otherwise (median cosine 0.998 between x86-64 and arm64).
PARITY_SLACK = 0.005  # cosine
# Other versions and builds of Python, numpy and ONNX Runtime map other amounts of code.
MEMORY_SLACK = 0.15  # share of the card's value


@dataclass(frozen=True)
class Row:
    """One figure: what the card states, what was measured here (None: not stated, not measured), and the verdict."""

    label: str
    unit: str
    stated: float | None
    measured: float | None
    verdict: str

    def __str__(self) -> str:
        stated, measured = ("-" if value is None else f"{value:g}" for value in (self.stated, self.measured))
        return f"  {self.label:36} {stated:>9} {measured:>9} {self.unit:3} {self.verdict}".rstrip()


LABELS = {
    "image_parity": ("image, median cosine to float32", ""),
    "image_parity_min": ("image, least cosine to float32", ""),
    "text_parity": ("text, median cosine to float32", ""),
    "image_memory": ("runtime, image tower: peak PSS", "MB"),
    "encoder_memory": ("with OpenCV, preprocessing: peak PSS", "MB"),
    "text_memory": ("runtime, text tower: peak PSS", "MB"),
    "size": ("all files", "MB"),
    "image_p50": ("image pass, p50", "ms"),
    "image_p95": ("image pass, p95", "ms"),
    "text_p50": ("text pass, p50", "ms"),
    "text_p95": ("text pass, p95", "ms"),
}
HEADER = f"  {'':36} {'card':>9} {'here':>9}"


def verify(manifest: Manifest) -> list[Row]:
    """Measure a model, whose files are whole, again. Raises ModelError or ProbeFailed when it does not run."""
    return compare(manifest.measured, measure(manifest))


def compare(stated: dict[str, float], measured: dict[str, float]) -> list[Row]:
    """A row for each figure that either side has."""
    rows = []
    for name, (label, unit) in LABELS.items():
        card, here = stated.get(name), measured.get(name)
        if card is not None or here is not None:
            rows.append(Row(label, unit, card, here, _verdict(name, card, here)))
    return rows


def sound(rows: list[Row]) -> bool:
    """Whether nothing that is judged differs."""
    return all(not row.verdict.startswith("differs") for row in rows)


def _verdict(name: str, card: float | None, here: float | None) -> str:
    if name.endswith(("p50", "p95")):
        return "(depends on the machine)"
    if card is None:
        return "(the card does not say)"
    if here is None:
        return "differs: it cannot be measured, the model has no reference.npz"
    if "parity" in name:
        return "ok" if here >= card - PARITY_SLACK else f"differs by more than {PARITY_SLACK}"
    if name.endswith("memory"):
        return "ok" if here <= card * (1 + MEMORY_SLACK) else f"differs: more than {MEMORY_SLACK:.0%} above"
    return "ok" if here == card else "differs"
