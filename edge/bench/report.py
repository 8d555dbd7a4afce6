"""What was measured: stages, sizes and processes, as a table and as a file that a later run is compared with."""

import json
import os
import platform
import re
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

STEP = "whole step"  # the stage of perception and planning in one control period
# Student's t at 97.5 % by degrees of freedom from 1; further ones change little.
T = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26)


class ReportError(ValueError):
    """A file that holds no report; the message says so."""


@dataclass(frozen=True)
class Stage:
    """Latency [ms] of one stage over all its calls, and half the 95 % interval of the median over processes."""

    p50: float
    p95: float
    max: float
    mean: float
    interval: float
    calls: int

    @classmethod
    def of(cls, runs: list[list[float]]) -> "Stage":
        """From the times [ms] of the calls in each of several fresh processes."""
        medians, times = np.array([np.median(run) for run in runs]), np.concatenate(runs)
        half = np.nan
        if len(runs) > 1:
            half = T[min(len(runs) - 1, len(T)) - 1] * medians.std(ddof=1) / np.sqrt(len(runs))
        p50, p95 = np.quantile(times, (0.5, 0.95))
        figures = p50, p95, times.max(), times.mean(), half
        return cls(*(round(float(figure), 4) for figure in figures), len(times))


@dataclass(frozen=True)
class Process:
    """Proportional set size [MB]: the highest reading with its parts, and what was left when the work was done."""

    peak: float
    anonymous: float
    file_backed: float
    steady: float
    rss: float  # the highest resident set, for comparison: shared pages in full


@dataclass
class Report:
    """Names are ``subject: what``."""

    machine: str
    model: str
    runs: int = 0  # the most fresh processes of a subject that were timed
    stages: dict[str, Stage] = field(default_factory=dict)
    processes: dict[str, Process] = field(default_factory=dict)
    sizes: dict[str, float] = field(default_factory=dict)  # MB
    recording: str = ""  # sha256, the first of it, of what the missions lived through

    @property
    def origin(self) -> tuple[str, str, str]:
        """What the figures are of; others are not quite comparable."""
        return self.machine, self.model, self.recording

    def save(self, path: Path) -> None:
        path.write_text(json.dumps(asdict(self), indent=1))

    @classmethod
    def load(cls, path: Path) -> "Report":
        """Raises ReportError when there is none in the file."""
        try:
            raw = json.loads(path.read_text())
            stages = {name: Stage(**stage) for name, stage in raw.pop("stages").items()}
            processes = {name: Process(**process) for name, process in raw.pop("processes").items()}
            return cls(**raw, stages=stages, processes=processes)
        except OSError as error:
            raise ReportError(f"{path} cannot be read ({error.strerror}); make it with --json {path}") from None
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise ReportError(f"{path} is no report of this benchmark; make it anew with --json {path}") from error

    def __str__(self):
        lines = [
            f"{'; '.join(filter(None, self.origin))}; one core, {self.runs} fresh processes of each kind timed at most"
        ]
        if self.stages:
            lines += ["", f"{'stage, ms':56} {'p50':>8} {'±':>6} {'p95':>8} {'max':>8} {'calls':>7}"]
            for name, stage in self.stages.items():
                figures = f"{stage.p50:8.2f} {stage.interval:6.2f} {stage.p95:8.2f} {stage.max:8.2f}"
                lines.append(f"{name:56} {figures} {stage.calls:7}")
        if self.processes:
            heads = f"{'peak':>7} {'= anonymous + file':>20} {'steady':>7} {'peak RSS':>9}"
            lines += ["", f"{'process, PSS in MB':40} {heads}"]
            for name, process in self.processes.items():
                parts = f"{process.anonymous:.1f} + {process.file_backed:.1f}"
                lines.append(f"{name:40} {process.peak:7.1f} {parts:>20} {process.steady:7.1f} {process.rss:9.1f}")
        if self.sizes:
            lines += ["", "size, MB", *(f"{name:56} {size:8.2f}" for name, size in self.sizes.items())]
        return "\n".join(lines)


def this_machine() -> str:
    """In words."""
    cores = f"{len(os.sched_getaffinity(0))} cores"
    return ", ".join(filter(None, (platform.machine(), _model(), cores, f"{platform.system()} {platform.release()}")))


def _model() -> str:
    """Of the board, or else of the processor, as the kernel names it; "" where it does not."""
    for file, pattern in (("/proc/device-tree/model", r"([^\0]+)"), ("/proc/cpuinfo", r"model name\s*: (.+)")):
        with suppress(OSError):
            if found := re.search(pattern, Path(file).read_text()):
                return found[1].strip()
    return ""
