"""Write a model folder's ``manifest.json``."""

import hashlib
import json
from pathlib import Path


def write_manifest(folder: Path, fields: dict) -> None:
    """``fields`` plus name, size and sha256 of every file in ``folder`` but the manifest and the card."""
    files = []
    for path in sorted(folder.iterdir()):
        if path.name not in ("manifest.json", "MODEL_CARD.md") and not path.name.startswith("."):
            path.chmod(0o644)  # onnx writes external data for its owner alone
            content = path.read_bytes()
            files.append({"name": path.name, "sha256": hashlib.sha256(content).hexdigest(), "size": len(content)})
    text = json.dumps(fields | {"files": files}, indent=2)
    partial = folder / ".manifest.part"
    partial.write_text(text + "\n")
    partial.rename(folder / "manifest.json")
