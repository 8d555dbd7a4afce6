"""``python -m tools.train [STAGE…]``: reproduce the shipped encoder. Without stages, all of them in order."""

import argparse
import os
from pathlib import Path

os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")

from models.manifest import DEFAULT  # noqa: E402
from tools.assets.catalog import INSTALLED  # noqa: E402

STAGES = ("fetch", "render", "features", "train", "export", "quantize", "reference", "evaluate", "card")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tools.train", description=__doc__)
    parser.add_argument("stages", nargs="*", choices=[*STAGES, []], metavar="STAGE", help=", ".join(STAGES))
    parser.add_argument("--furniture", type=Path, default=INSTALLED, help="folder of Sweet Home 3D's .sh3f libraries")
    parser.add_argument("--work", type=Path, default=Path("build/train"), help="folder for what can be made again")
    parser.add_argument("--model", type=Path, default=Path("models") / DEFAULT, help="folder of the finished model")
    options = parser.parse_args()

    from tools.train.fetch import FetchError
    from tools.train.pipeline import Pipeline

    pipeline = Pipeline(options.furniture, options.work, options.model)
    try:
        for stage in options.stages or STAGES:
            print(f"{stage} …", flush=True)
            getattr(pipeline, stage)()
    except (FetchError, FileNotFoundError) as error:
        parser.exit(2, f"python -m tools.train: {error}\n")


if __name__ == "__main__":
    main()
