"""``vlpg deploy``: put the robot on a board."""

import argparse
from pathlib import Path

from edge.process import cache_file
from models.manifest import DEFAULT, Manifest, ModelError, resolve, sha256
from tools.deploy.bundle import BundleConfig, make
from tools.deploy.target import MACHINES, PYTHONS, DeployError, Target
from tools.deploy.wheels import resolve as resolve_wheels
from tools.deploy.wheels import write_lock


def main(arguments: list[str] | None = None) -> None:
    """``vlpg deploy``."""
    parser = argparse.ArgumentParser(prog="vlpg deploy", description=__doc__.split(": ", 1)[1])
    commands = parser.add_subparsers(dest="command", required=True)
    bundle = commands.add_parser("bundle", help="make one archive of the robot, that installs without a network")
    bundle.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    bundle.add_argument("--offload", action="store_true", help="leave the text tower to a host")
    bundle.add_argument("--out", type=Path, default=Path("."), metavar="FOLDER", help="where it is written")
    lock = commands.add_parser("lock", help="choose the newest wheels of the robot's dependencies, for later bundles")
    for command in (bundle, lock):
        command.add_argument("--target", choices=MACHINES, default=Target.machine, help="default: %(default)s")
        command.add_argument("--python", choices=PYTHONS, default=Target.python, help="default: %(default)s")
    options = parser.parse_args(arguments)
    target = Target(options.target, options.python)
    try:
        if options.command == "lock":
            locked = resolve_wheels(target)
            write_lock(target, locked)
            print("\n".join(f"{one.name} {one.version}" for one in locked))
        else:
            config = BundleConfig(target, Manifest.load(resolve(options.model)), options.offload)
            cache = cache_file(f"wheels/{target.name}") or Path("wheels") / target.name
            path = make(config, options.out, cache)
            print(f"{path}  {path.stat().st_size / 1e6:.1f} MB  sha256 {sha256(path)}")
    except (DeployError, ModelError, OSError) as error:
        parser.exit(2, f"vlpg deploy {options.command}: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "")


if __name__ == "__main__":
    main()
