"""``vlpg eval confidence``: can the confidence of claims be believed, and which weights would make it more so?"""

import argparse
import json
from dataclasses import asdict, replace
from pathlib import Path

from models.manifest import Manifest, ModelError, resolve
from tools.eval.campaign import read
from tools.eval.reliability import claims_of, draw, fit, seen, show


def main(arguments: list[str] | None = None) -> None:
    """``vlpg eval confidence``."""
    parser = argparse.ArgumentParser(prog="vlpg eval confidence", description=__doc__.split(": ", 1)[1])
    parser.add_argument("episodes", type=Path, help="file that `vlpg eval find --search --json` wrote")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw the reliability diagram")
    parser.add_argument("--write", metavar="MODEL", help="put the fitted weights into this model's manifest")
    options = parser.parse_args(arguments)
    try:
        claims = claims_of([e for result in read(options.episodes) for e in result.episodes])
        print(f"as stated\n{show(claims)}")
        if options.picture:
            draw(claims, options.picture)
        sightings = seen(claims)
        fitted = fit(sightings)
        refitted = [replace(e, confidence=fitted(e.score, e.remembered)) for e in sightings]
        print(f"\nfitted to those that rest on a sighting: {json.dumps(asdict(fitted))}\n{show(refitted)}")
        if options.write:
            write(fitted, resolve(options.write))
    except (OSError, ValueError, ModelError) as error:
        parser.exit(2, f"vlpg eval confidence: {error}\n")


def write(fitted, folder: Path) -> None:
    """Put the weights into the manifest; its digest, which is of the weights of the towers, stays."""
    Manifest.load(folder)  # whether it is one
    path = folder / "manifest.json"
    raw = json.loads(path.read_text())
    path.write_text(json.dumps(raw | {"confidence": asdict(fitted)}, indent=2) + "\n")


if __name__ == "__main__":
    main()
