"""``vlpg deploy``: put the robot on a board, and look after it there."""

import argparse
from contextlib import suppress
from pathlib import Path

from edge.bench.__main__ import SUBJECTS
from edge.bench.recording import Recording, RecordingError
from edge.budget import BUDGETS
from edge.process import cache_file
from models.manifest import DEFAULT, Manifest, ModelError, resolve, sha256
from tools.bench.command import usual_recording
from tools.deploy.bundle import BundleConfig, contents, make
from tools.deploy.remote import SSH, Board
from tools.deploy.target import MACHINES, PYTHONS, DeployError, Target
from tools.deploy.wheels import resolve as resolve_wheels
from tools.deploy.wheels import write_lock


def main(arguments: list[str] | None = None) -> None:
    """``vlpg deploy``. Exit code 1: the board's doctor found something bad, or it is over its budget."""
    parser = argparse.ArgumentParser(prog="vlpg deploy", description=__doc__.split(": ", 1)[1])
    commands = parser.add_subparsers(dest="command", required=True)

    def command(name: str, does, told: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=told, description=told)
        added.set_defaults(does=does)
        return added

    bundle = command("bundle", _bundle, "make one archive of the robot, that installs without a network")
    lock = command("lock", _lock, "choose the newest wheels of the robot's dependencies, for later bundles")
    push = command("push", _push, "install the robot on a board over ssh, and let its doctor look at it")
    bench = command("bench", _bench, "measure speed and memory on a board, by a recording of a simulated home")
    status = command("status", _status, "which version is installed, and how the service is")
    logs = command("logs", _logs, "what the robot writes")
    rollback = command("rollback", _rollback, "go back to the version before")
    for made in (bundle, push, bench):
        made.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    for made in (bundle, push):
        made.add_argument("--offload", action="store_true", help="leave the text tower to a host")
    bundle.add_argument("--out", type=Path, default=Path("."), metavar="FOLDER", help="where it is written")
    for made in (bundle, lock):
        made.add_argument("--target", choices=MACHINES, default=Target.machine, help="default: %(default)s")
        made.add_argument("--python", choices=PYTHONS, default=Target.python, help="default: %(default)s")
    for there in (push, bench, status, logs, rollback):
        there.add_argument("board", metavar="USER@BOARD")
        there.add_argument("--ssh", default=SSH, metavar="COMMAND", help="default: %(default)s")
        there.add_argument("--root", default="", metavar="DIR", help="installed below that folder of the board")
    bench.add_argument("what", choices=SUBJECTS)
    bench.add_argument("--recording", type=Path, metavar="FILE", help="default: the one that vlpg bench uses here")
    bench.add_argument("--budget", choices=list(BUDGETS), help="exit code 1 if a figure is over this board's")
    bench.add_argument("--runs", type=int, metavar="N", help="processes of each kind")
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, here, too")
    logs.add_argument("--follow", action="store_true", help="go on until Ctrl-C")
    options = parser.parse_args(arguments)
    try:
        raise SystemExit(options.does(options))
    except (DeployError, ModelError, RecordingError, OSError) as error:
        parser.exit(2, f"vlpg deploy {options.command}: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "")


def _bundle(options) -> int:
    config = BundleConfig(
        Target(options.target, options.python), Manifest.load(resolve(options.model)), options.offload
    )
    path = make(config, options.out, _cache(config.target))
    print(f"{path}  {path.stat().st_size / 1e6:.1f} MB  sha256 {sha256(path)}")
    return 0


def _lock(options) -> int:
    target = Target(options.target, options.python)
    locked = resolve_wheels(target)
    write_lock(target, locked)
    print("\n".join(f"{one.name} {one.version}" for one in locked))
    return 0


def _push(options) -> int:
    board, model = _board(options), Manifest.load(resolve(options.model))
    facts = board.probe()
    print(f"{options.board}: {facts}")
    config = BundleConfig(facts.target(options.offload), model, options.offload)
    content = contents(config, _cache(config.target))
    number, size = board.send(content)
    print(f"sent {number} files, {size / 1e6:.1f} MB; what had not changed was there already")
    try:
        print(board.install().strip())
    except DeployError:
        with suppress(DeployError):  # the board may be gone
            if board.release() == content["release"].decode().strip():  # it is installed, and does not start
                print(board.doctor()[0].rstrip(), flush=True)
                board.logs()
        raise
    table, well = board.doctor()
    print(table.rstrip())
    return 0 if well else 1


def _bench(options) -> int:
    recording = options.recording or usual_recording(options.model)
    Recording(recording)  # whether it is one is said before it is sent
    chosen = {"--model": Path(options.model).name, "--budget": options.budget, "--runs": options.runs}
    arguments = [str(word) for flag, value in chosen.items() if value is not None for word in (flag, value)]
    code, report = _board(options).bench(recording, [options.what, *arguments])
    if options.json and code in (0, 1):
        options.json.write_text(report())
    return code


def _status(options) -> int:
    board = _board(options)
    release = board.release()
    print(f"installed: {release or 'nothing'}")
    return 1 if not release else 0 if options.root else board.attach("systemctl --no-pager status vlpg-robot")


def _logs(options) -> int:
    return _board(options).logs(options.follow)


def _rollback(options) -> int:
    print(_board(options).rollback().strip())
    return 0


def _board(options) -> Board:
    return Board(options.board, options.ssh, options.root)


def _cache(target: Target) -> Path:
    return cache_file(f"wheels/{target.name}") or Path("wheels") / target.name


if __name__ == "__main__":
    main()
