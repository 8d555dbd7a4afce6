"""Runs the subjects, each in fresh processes, until their medians are known well enough."""

import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from edge.bench.overruns import BOARD, HOST
from edge.bench.probe_process import ProbeProcess
from edge.bench.report import Process, Report, Stage, this_machine

WEIGHED = 2  # processes whose memory is read; that holds them up, so that others are timed
FEWEST, MOST = 3, 10  # processes that are timed
CLOSE = 0.05  # half the 95 % interval of a median, as a share of it, that is small enough
AS_INSTALLED = ("-OO",)  # how a board's commands start Python (install.sh): without docstrings, which take 2 MB
FOLDER = "{folder}"  # stands for a new one in a process's arguments
SHORT, RARE = 1.0, 20  # ms and calls in all; of shorter or rarer stages the medians need not be that close


@dataclass(frozen=True)
class Subject:
    """A process to measure."""

    name: str
    module: str
    arguments: tuple[str, ...]
    period: float = ProbeProcess.PERIOD  # s between readings of its memory


def subjects(what: str, recording: Path | None, model: str, text: bool = True) -> list[Subject]:
    """Those of ``vlpg bench WHAT``; without ``text``, of a robot that has no text tower."""
    file = str(recording)
    # Missions take minutes, and a reading of their memory a millisecond or two.
    board = Subject(BOARD, "edge.bench.mission", (file, model, "board", FOLDER), 0.01)
    host = Subject(HOST, "edge.bench.mission", (file, model, "host", FOLDER), 0.01)
    everything = {
        "encoder": [Subject("encoder", "edge.bench.encoder", (model, "board" if text else "host"))],
        "store": [Subject("store", "edge.bench.store", ())],
        "planning": [Subject("planning", "edge.bench.planning", (file,), 0.01)],
        "mission": [board, host] if text else [host],
    }
    return sum(everything.values(), []) if what == "all" else everything[what]


def measure(
    what: list[Subject], model: str, fewest=FEWEST, most=MOST, tell: Callable[[str], None] = print
) -> Iterator[Report]:
    """One report, yielded after each subject, as it grows. Raises ProbeFailed when one does not run."""
    report = Report(this_machine(), model)
    for subject in what:
        runs: dict[str, list[list[float]]] = {}
        count = 0
        while count < fewest or count < most and not _close(runs):
            count += 1
            tell(f"{subject.name}: process {count} is timed")
            for stage, times in run(subject)["stages"].items():
                runs.setdefault(stage, []).append(times)
        report.stages |= {f"{subject.name}: {stage}": Stage.of(times) for stage, times in runs.items()}
        report.runs = max(report.runs, count)
        processes: list[Process] = []
        # After the others: a process that finds no compiled code compiles, and keeps what that took.
        for number in range(WEIGHED):
            tell(f"{subject.name}: process {number + 1} is weighed")
            said, process = weigh(subject)
            processes.append(process)
            report.sizes |= {f"{subject.name}: {name}": size for name, size in said["sizes"].items()}
        report.processes[subject.name] = max(processes, key=lambda process: process.peak)
        yield report


def weigh(subject: Subject, limit: Callable[[], None] | None = None) -> tuple[dict, Process]:
    """What one process said, slower than by itself, and took."""
    with _begun(subject, subject.period, limit) as probe:
        now = probe.now
        peak = max(probe.peak, now, key=lambda usage: usage.pss)  # the last reading may have come before the end
    figures = peak.pss, peak.anonymous, peak.file_backed, now.pss, peak.rss
    return json.loads(probe.said), Process(*(round(figure, 1) for figure in figures))


def run(subject: Subject) -> dict:
    """What one process said that nobody disturbed."""
    with _begun(subject, None) as probe:
        return json.loads(probe.said)


@contextmanager
def _begun(subject: Subject, period: float | None, limit: Callable[[], None] | None = None) -> Iterator[ProbeProcess]:
    with tempfile.TemporaryDirectory() as folder:
        arguments = (folder if argument == FOLDER else argument for argument in subject.arguments)
        with ProbeProcess(subject.module, *arguments, period=period, limit=limit, flags=AS_INSTALLED) as probe:
            yield probe


def _close(runs: dict[str, list[list[float]]]) -> bool:
    stages = [Stage.of(times) for times in runs.values()]
    return all(stage.interval <= CLOSE * stage.p50 for stage in stages if stage.p50 >= SHORT and stage.calls > RARE)
