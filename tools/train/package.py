"""Write a model folder's ``manifest.json``."""

import hashlib
import json
from pathlib import Path

CARD = (".md", ".jpg")  # endings of the card and its pictures, which say what the model is and are no part of it


def write_manifest(folder: Path, fields: dict) -> None:
    """``fields`` plus name, size and sha256 of every file in ``folder`` but the manifest, the card and its pictures."""
    files = []
    for path in sorted(folder.iterdir()):
        if path.name != "manifest.json" and path.suffix not in CARD and not path.name.startswith("."):
            path.chmod(0o644)  # onnx writes external data for its owner alone
            content = path.read_bytes()
            files.append({"name": path.name, "sha256": hashlib.sha256(content).hexdigest(), "size": len(content)})
    text = json.dumps(fields | {"files": files}, indent=2)
    partial = folder / ".manifest.part"
    partial.write_text(text + "\n")
    partial.rename(folder / "manifest.json")
