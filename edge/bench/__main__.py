"""``vlpg bench``, and ``vlpg-bench`` on a board: speed and memory of the robot's parts and of whole missions."""

import argparse
import math
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from edge.bench.baseline import regressions
from edge.bench.limit import MemoryLimit
from edge.bench.measure import FEWEST, MOST, Subject, measure, subjects, weigh
from edge.bench.overruns import BOARD, HOST, PERIOD, overruns, spent
from edge.bench.probe_process import ProbeFailed
from edge.bench.recording import Recording, RecordingError
from edge.bench.report import STEP, Report, ReportError
from edge.budget import BUDGETS
from models.manifest import DEFAULT, Manifest, ModelError, resolve, sha256

SUBJECTS = ["encoder", "store", "planning", "mission", "all"]
BUDGETED = ["store", "mission", "all"]
UNHURRIED = 0.5  # s between readings of a process under a hard limit, which does the weighing itself


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", choices=SUBJECTS)
    parser.add_argument("--recording", type=Path, metavar="FILE", help="of the home in which to plan and to search")
    parser.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    parser.add_argument("--budget", choices=list(BUDGETS), help="exit code 1 if a figure is over this board's")
    parser.add_argument(
        "--runs", type=int, metavar="N", help=f"processes of each kind that are timed (default: {FEWEST} to {MOST})"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    parser.add_argument("--against", type=Path, metavar="FILE", help="exit code 1 if worse than this earlier --json")
    parser.add_argument(
        "--enforce", type=_megabytes, nargs="?", const=0.0, metavar="MB",
        help="run the missions under a hard limit of memory (default: the budget's)",
    )  # fmt: skip


def _megabytes(text: str) -> float:
    with suppress(ValueError):
        if 0 < float(text) < math.inf:
            return float(text)
    raise argparse.ArgumentTypeError(f"{text} MB is no limit; take a number above 0")


def main(
    arguments: list[str] | None = None,
    program: str = "vlpg-bench",
    epilog: str | None = None,
    recording: Callable[[str], Path] | None = None,
) -> None:
    """``recording`` gives the file of the one to use, for a model, when none is named."""
    parser = argparse.ArgumentParser(
        prog=program,
        description="Measure each part of the robot in fresh processes on one core, and compare with a board's budget.",
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_arguments(parser)
    options = parser.parse_args(arguments)
    needs_recording = options.what in ("planning", "mission", "all") and options.recording is None
    if needs_recording and recording is None:
        parser.error("this needs a --recording; where the simulator is, vlpg bench record FILE makes one")
    if options.enforce is not None and options.what not in ("mission", "all"):
        parser.error("--enforce: only missions run under a limit")
    if options.enforce is not None and (options.json or options.against or options.runs):
        parser.error("--enforce says only whether the missions finish; --json, --against and --runs are for measuring")
    if options.budget and options.what not in BUDGETED:
        parser.error(f"no budget limits {options.what}; use it with {', '.join(BUDGETED)}")
    if options.json and not options.json.parent.is_dir():
        parser.error(f"there is no folder {options.json.parent} to write {options.json.name} into")
    if options.enforce == 0.0 and not options.budget:
        parser.error("--enforce needs a --budget, or a limit in MB")
    if options.runs is not None and options.runs < 1:
        parser.error("--runs must be at least 1")
    try:
        if needs_recording:
            options.recording = recording(options.model)
        raise SystemExit(bench(options))
    except (ModelError, RecordingError, ReportError, ProbeFailed, OSError, subprocess.SubprocessError) as error:
        parser.exit(2, f"{program}: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, f"\n{program}: stopped\n")


def bench(options: argparse.Namespace) -> int:
    """Exit code. Raises ModelError, RecordingError, ReportError and ProbeFailed."""
    before = options.against and Report.load(options.against)
    manifest = Manifest.load(resolve(options.model))
    if not manifest.has_text:
        _tell(f"{manifest.name} is here without its text tower: measured as with a host that encodes text")
    manifest.verify(manifest.has_text)
    if options.recording:
        Recording(options.recording)  # whether it is one is said before anything is measured
    what = subjects(options.what, options.recording, options.model, manifest.has_text)
    if options.enforce is not None:
        return enforce([subject for subject in what if subject.name in (BOARD, HOST)], options)
    limits = (options.runs, options.runs) if options.runs else (FEWEST, MOST)
    recorded = sha256(options.recording)[:12] if options.recording else ""
    for report in measure(what, options.model, *limits, tell=_tell):
        report.recording = recorded
        if options.json:  # what is done is kept: on a slow board the rest takes hours
            report.save(options.json.with_suffix(".part"))
    if options.json:
        options.json.with_suffix(".part").rename(options.json)
    print(report)
    if before and before.origin != report.origin:
        print(f"compared with another machine, model or recording: {'; '.join(before.origin)}")
    for name, stage in report.stages.items():
        if name.endswith(STEP):
            print(f"{name}: {stage.mean / PERIOD:.0%} of this core at 10 Hz")
    problems = overruns(report, BUDGETS[options.budget]) if options.budget else []
    problems += regressions(report, before) if before else []
    for problem in problems:
        print(f"OVER  {problem}")
    if options.budget and not problems:
        judged = [name for name, *_ in spent(report, BUDGETS[options.budget])]
        print(f"within the budget {options.budget}, on this machine: {'; '.join(judged)}")
    return bool(problems)


def enforce(missions: list[Subject], options: argparse.Namespace) -> int:
    """Run each mission under a limit; exit code 1 when one does not finish, or takes more."""
    for subject in missions:
        budget = BUDGETS[options.budget] if options.budget else None
        limit = options.enforce or budget.peak(text=subject.name == BOARD)
        with MemoryLimit(limit) as hard:
            under = f"{subject.name} under {limit:g} MB by {hard.kind}"
            try:
                _, process = weigh(replace(subject, period=UNHURRIED), hard.enter)
            except ProbeFailed as error:
                print(f"OVER  {under}: {error}")
                return 1
            took = f"peak PSS {process.peak:.1f} MB, {process.anonymous:.1f} of it anonymous"
            if hard.peak is not None:
                took += f"; {hard.peak:.1f} MB by the group's own count"
        if process.peak > limit:  # files that are mapped may not count for the limit
            print(f"OVER  {under}: finished; {took}")
            return 1
        print(f"{under}: finished; {took}")
    return 0


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
