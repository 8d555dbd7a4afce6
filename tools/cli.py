"""The ``vlpg`` command. What a command needs is imported when it runs: ``vlpg --help`` answers at once."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

try:
    import typer
except ModuleNotFoundError:
    sys.exit("vlpg: the command line needs: pip install '.[tools]'; the robot alone is started by vlpg-robot")

# Where everything on one machine meets, as long as nobody says otherwise; nothing leaves the machine.
MEETING_PLACE = "tcp/127.0.0.1:7447"

app = typer.Typer(
    help="Map a home, then find things in it by their names. Without zenoh flags, the commands of one machine meet on "
    f"{MEETING_PLACE}; with any of them, as those say.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
models_app = typer.Typer(help="The encoders that are at hand.", no_args_is_help=True)
eval_app = typer.Typer(help="Measure how well the whole system, or a part of it, does.", no_args_is_help=True)
app.add_typer(models_app, name="models")
app.add_typer(eval_app, name="eval")

DIFFERS, MISTAKE, INTERRUPTED = 1, 2, 130  # exit codes

_LINK_FLAGS = ("--connect", "-e", "--listen", "-l", "--mode", "-m", "--config", "-c", "--no-multicast-scouting")


def main() -> None:
    """Entry point of the ``vlpg`` script."""
    app()


@contextmanager
def _explained(*mistakes: type[Exception]) -> Iterator[None]:
    """Turns the user's mistakes into one sentence on stderr, and Ctrl-C into silence."""
    try:
        yield
    except mistakes as error:
        typer.echo(f"vlpg: {error}", err=True)
        raise typer.Exit(MISTAKE) from None
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None


def _join(program: str, arguments: list[str], meeting: tuple[str, ...]) -> None:
    """``_become`` a part of the system; without zenoh flags, with those of the ``meeting``."""
    if not any(_is_link_flag(argument) for argument in arguments):
        arguments = [*arguments, *meeting]
    _become(program, arguments)


def _is_link_flag(argument: str) -> bool:
    if argument.startswith("--"):  # --model is not --mode
        return argument.split("=")[0] in _LINK_FLAGS
    return argument.startswith("-") and argument[:2] in _LINK_FLAGS  # -etcp/… as well as -e tcp/…


def _become(program: str, arguments: list[str]) -> None:
    """Replace this process by ``python -m program``: on a small robot, nothing of the command line stays in memory."""
    os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads' stacks are 176 MB of address space
    sys.stdout.flush()
    os.execv(sys.executable, [sys.executable, "-P", "-m", *program.split(), *arguments])


def _part(command: str, program: str, summary: str, meeting: tuple[str, ...] = ()) -> None:
    """Adds a command that is a ``program`` of its own, a module and what comes first of its arguments.

    It reads the others itself, --help included. Where it has a ``meeting``, it needs zenoh flags.
    """
    *group, name = command.split()

    @(eval_app if group else app).command(
        name,
        help=f"{summary} (vlpg {command} --help).",
        context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
        add_help_option=False,
    )
    def run(context: typer.Context) -> None:
        _join(program, context.args, meeting)


_THERE = (MEETING_PLACE, "--no-multicast-scouting")
_CONNECT = ("--connect", *_THERE)
_ASK = (*_CONNECT, "--mode", "client")  # a client notices at once when nobody listens there

_part("sim", "firmware_sim.node", "Run the simulated base in a furnished home", ("--listen", *_THERE))
_part("robot", "edge.node", "Run the robot: maps the home it wakes up in, then answers", _CONNECT)
_part("host", "host.node", "Run the host, which takes work off robots", _CONNECT)
_part("doctor", "edge.doctor", "Look whether this machine can run the robot, and say what to do if not", _CONNECT)
_part("reindex", "edge.reindex", "Move a home's memory to another encoder, by looking again at its pictures")
_part("deploy", "tools.deploy.command", "Put the robot on a board")
_part("bench", "tools.bench.command", "Measure speed and memory on this machine")
_part("find", "tools.ask find", "Ask the robot to find something", _ASK)
_part("tour", "tools.ask tour", "Let the robot look at its whole home again, so that it learns what has changed", _ASK)
_part("status", "tools.ask status", "What the robot is doing, where it is, and how it fares", _ASK)
_part("cancel", "tools.ask cancel", "Stop what the robot is doing: a search, or a tour of its home", _ASK)
_part("eval find", "tools.eval.find", "Find everything in many homes and count")
_part("eval confidence", "tools.eval.confidence", "Tell how far the confidence of claims can be believed, and fit it")
_part("eval encoder", "tools.eval.encoder", "Name pictures of objects the encoder was never trained on")
_part("eval graph", "tools.eval.graph", "Straighten the graph of a robot that drifts")
_part("eval life", "tools.eval.life", "Change homes between tours, and count what the memory still gets right")
_part("eval objectnav", "tools.eval.objectnav.command", "Find things in homes never seen before and count")
_part("eval overlay", "tools.eval.objectnav.overlay", "Draw a search through an unknown home, step by step")


@app.command()
def demo(
    home: Annotated[str, typer.Option(help="apartment, cottage, bungalow, a file, or generated:SEED")] = "apartment",
    objects: Annotated[
        list[str] | None, typer.Option("--object", help="what to find, in any words; may be repeated")
    ] = None,
    search: Annotated[bool, typer.Option("--search", help="look at guesses too; answer with the best")] = False,
    offload: Annotated[str, typer.Option(help="who encodes text: never (the robot), host, or auto")] = "never",
    seed: Annotated[int, typer.Option(min=0, help="seed of the sensors' noise")] = 0,
    speed: Annotated[float, typer.Option(min=0.1, help="simulated seconds a second, at most")] = 8.0,
    out: Annotated[Path, typer.Option(help="folder that gets a folder for each run")] = Path("runs"),
) -> None:
    """Map a furnished home in simulation, find things in it, and write a report. Takes up to 5 minutes."""
    from firmware_sim.furniture import FurnitureError
    from firmware_sim.house import HouseError
    from tools.demo.demo import DemoConfig, DemoError, run_demo

    with _explained(DemoError, HouseError, FurnitureError, OSError):
        raise typer.Exit(run_demo(DemoConfig(home, tuple(objects or ()), search, offload, seed, speed, out)))


@models_app.command("list")
def models_list() -> None:
    """Name, size and digest of each model, shipped or your own."""
    from models.manifest import ModelError

    with _explained(ModelError):
        for manifest in _manifests(None):
            size = sum(file.size for file in manifest.files) / 1e6
            line = f"{manifest.folder.name:20} {size:6.1f} MB  {manifest.dim}-d  sha256 {manifest.digest[:12]}"
            typer.echo(f"{line}  {manifest.source}".rstrip())


@models_app.command("import")
def models_import(
    source: Annotated[str, typer.Argument(metavar="SOURCE", help="see above")],
    name: Annotated[str, typer.Option(help="what to call it here")],
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="weights for an OpenCLIP architecture")
    ] = None,
) -> None:
    """Make a model of your own out of another framework's.

    SOURCE is an OpenCLIP architecture with its weights, as ViT-B-32@laion2b_s34b_b79k or as ViT-B-32 with --checkpoint
    FILE; a folder in Hugging Face's or OpenCLIP's form or with a pair of ONNX graphs; or such a folder on a hub, as
    ORGANISATION/NAME or ORGANISATION/NAME@REVISION. HF_ENDPOINT, HF_TOKEN and HF_HUB_OFFLINE are heeded. Takes minutes,
    and the extra `import`.
    """
    from edge.bench.probe_process import ProbeFailed
    from models.manifest import ModelError
    from tools.models.command import import_model

    with _explained(ModelError, ProbeFailed, OSError):
        import_model(source, name, checkpoint)


@models_app.command("pull")
def models_pull(
    source: Annotated[str, typer.Argument(help="http(s) address of a model folder, or a hub's ORGANISATION/NAME")],
    name: Annotated[str | None, typer.Option(help="what to call it here; default: as its manifest does")] = None,
) -> None:
    """Fetch a finished model; one that was interrupted goes on where it was."""
    from models.manifest import ModelError
    from tools.models.command import pull_model

    with _explained(ModelError, OSError):
        pull_model(source, name)


@models_app.command("remove")
def models_remove(name: Annotated[str, typer.Argument(help="one of your own models")]) -> None:
    """Delete one of your own models."""
    from models.manifest import ModelError
    from tools.models.shelf import remove

    with _explained(ModelError, OSError):
        typer.echo(f"{remove(name)} is deleted")


@models_app.command("verify")
def models_verify(
    name: Annotated[str | None, typer.Argument(help="a model's name or folder; default: all")] = None,
    files_only: Annotated[bool, typer.Option("--files-only", help="do not measure anything again")] = False,
) -> None:
    """Check a model's files by sha256, measure it again, and compare with its card. Exit code 1: something differs."""
    from edge.bench.probe_process import ProbeFailed
    from models.manifest import ModelError
    from tools.models.verify import HEADER, sound, verify

    differs = False
    with _explained(ModelError, ProbeFailed):
        for manifest in _manifests(name):
            manifest.verify()
            typer.echo(f"{manifest.name}: {len(manifest.files)} files as in the manifest")
            if not files_only:
                rows = verify(manifest)
                typer.echo("\n".join([HEADER, *map(str, rows)]))
                differs |= not sound(rows)
    raise typer.Exit(DIFFERS if differs else 0)


def _manifests(name: str | None) -> Iterator:
    """The model of that name, or all that are at hand; of those that cannot be read it is said on stderr."""
    from models.manifest import Manifest, ModelError, folders, resolve

    if name is not None:
        yield Manifest.load(resolve(name))
        return
    mistakes = False
    for folder in folders().values():
        try:
            yield Manifest.load(folder)
        except ModelError as error:
            typer.echo(f"vlpg: {error}", err=True)
            mistakes = True
    if mistakes:
        raise typer.Exit(MISTAKE)


if __name__ == "__main__":
    main()
