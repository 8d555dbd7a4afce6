"""``vlpg eval encoder``: how well an encoder knows again, and points at, things in homes that it has never seen."""

import argparse

from edge.perception.encoder import Encoder
from models.manifest import DEFAULT, ModelError
from tools.train.evaluate import HOMES, evaluate_homes


def main(arguments: list[str] | None = None) -> None:
    """Prints one line for each figure."""
    parser = argparse.ArgumentParser(prog="vlpg eval encoder", description=__doc__.split(": ", 1)[1])
    parser.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    parser.add_argument("--homes", type=int, default=len(HOMES), help="generated homes, 120 views each (default: 8)")
    options = parser.parse_args(arguments)
    if options.homes < 1:
        parser.error("--homes must be at least 1")
    try:
        encoder = Encoder.load(options.model)
    except ModelError as error:
        parser.exit(2, f"vlpg eval encoder: {error}\n")
    result = evaluate_homes(encoder, range(HOMES.start, HOMES.start + options.homes))
    print(f"{encoder.name}, {options.homes} homes that no training has seen, 120 views each")
    print(f"of {result['queries']} names, a view that truly shows the thing is")
    print(f"  first            {result['first']:6.1%}")
    print(f"  among the first 10 {result['within10']:4.1%}")
    print(f"of {result['sightings']} things in view, the saliency")
    print(f"  peaks inside     {result['pointing']:6.1%}")
    print(f"  overlaps (IoU)   {result['iou']:6.1%}")


if __name__ == "__main__":
    main()
