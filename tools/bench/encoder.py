"""``vlpg bench peers encoder``: the image tower on one thread, beside what one would otherwise pick.

The same tower in float32 with PyTorch (extra ``train``), and in float32 with ONNX Runtime (package ``onnx``), each if
installed. Every tower has a process of its own. First each is weighed, alone; then all are timed in turns, a few passes
at a time, so that whatever else the machine does meets them alike.
"""

import argparse
import importlib.util
import json
import tempfile
from dataclasses import asdict
from pathlib import Path

from edge.bench.probe_process import ProbeFailed
from models.manifest import DEFAULT, Manifest, ModelError, resolve
from tools.bench.peers import TURNS, measure, show

OURS = "int8, ONNX Runtime, as on the robot"


def peers(manifest: Manifest, folder: Path) -> tuple[dict[str, tuple[str, ...]], list[str]]:
    """Command of each tower that can run here, ours first, and a sentence on each that cannot.

    ``folder`` gets the float32 graph.
    """
    size = (str(manifest.image.height), str(manifest.image.width))
    commands, missing = {OURS: ("tools.models.probe", "image", str(manifest.folder))}, []
    if importlib.util.find_spec("onnx"):
        from tools.bench.float_graph import dequantize

        graph = folder / "float32.onnx"
        dequantize(manifest.folder / manifest.image.graph, graph)
        commands["float32, ONNX Runtime"] = ("tools.bench.peer", "onnx", str(graph), *size)
    else:
        missing.append("float32 with ONNX Runtime is left out: it needs the package onnx (pip install onnx).")
    if manifest.name != DEFAULT:
        missing.append(f"float32 with PyTorch is left out: its code is here for {DEFAULT} only.")
    elif all(importlib.util.find_spec(name) for name in ("torch", "efficientnet_lite_pytorch")):
        commands["float32, PyTorch"] = ("tools.bench.peer", "torch", *size)
    else:
        missing.append("float32 with PyTorch is left out: it needs the extra train (pip install '.[train]').")
    return commands, missing


def main(arguments: list[str] | None = None) -> None:
    """``vlpg bench peers encoder``."""
    parser = argparse.ArgumentParser(prog="vlpg bench peers encoder", description=__doc__.split(": ", 1)[1])
    parser.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    parser.add_argument("--turns", type=int, default=TURNS, help="of timed passes (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    options = parser.parse_args(arguments)
    if options.turns < 1:
        parser.error("--turns must be at least 1")
    try:
        manifest = Manifest.load(resolve(options.model))
        manifest.verify()
        with tempfile.TemporaryDirectory() as folder:
            commands, missing = peers(manifest, Path(folder))
            found = measure(commands, options.turns)
    except (ModelError, ProbeFailed) as error:
        parser.exit(2, f"vlpg bench peers encoder: {error}\n")
    print(f"{manifest.name}, {manifest.image.height} x {manifest.image.width} px, {options.turns} turns")
    print(show(found))
    print("\n".join(missing))
    if options.json:
        options.json.write_text(json.dumps([asdict(peer) for peer in found], indent=1))


if __name__ == "__main__":
    main()
