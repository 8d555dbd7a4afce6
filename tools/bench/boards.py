"""``vlpg bench boards FILE``: an estimate of the robot's speed on boards where it was not measured.

FILE is a report of ``vlpg bench mission --json`` from this machine. What the towers take in it is scaled by published
times of networks of the same kind, int8, on each processor, and by how many multiplications they have; the rest, which
is Python, NumPy and OpenCV, by 7-zip's rating of one core. Such estimates are good to a factor of two: the published
times are of another runtime (XNNPACK), and a board with little cooling slows down.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

from edge.bench.overruns import BOARD
from edge.bench.report import STEP, Report, ReportError
from models.manifest import DEFAULT

MACS = 525  # millions of multiplications in a pass of the shipped image tower, over all its convolutions and products
TOWERS = ("encode a picture", "Grad-CAM", "encode two prompts")  # stages


@dataclass(frozen=True)
class Published:
    """A time that somebody measured and published, with all cores."""

    time: float  # ms
    macs: float  # millions
    clock: float  # GHz
    # Four threads are three times as fast as one: XNNPACK's README has 86 and 27, 53 and 18, 42 and 14 ms (Pixel 2).
    gain: float = 3.0


# MobileNet v2, int8 per channel: README of google/XNNPACK, 8 February 2022.
A53 = Published(30.0, 300, 1.4)  # Raspberry Pi 3+
A72 = Published(17.0, 300, 1.5)  # Raspberry Pi 4, arm64
# EfficientNet-Lite0, int8: README of tensorflow/tpu, models/official/efficientnet/lite.
A76 = Published(6.5, 407, 2.5)  # Pixel 4: one core of 2.84 GHz, three of 2.42


@dataclass(frozen=True)
class Board:
    """A board, its cores, and what 7-zip says of one of them."""

    name: str
    core: str
    clock: float  # GHz
    published: Published
    mips: float  # a fourth of the rating with four threads

    def tower(self, threads: int) -> float:
        """ms that a pass of the image tower takes with one thread or with four."""
        published = self.published
        once = published.time * MACS / published.macs * published.clock / self.clock
        return once if threads > 1 else once * published.gain


# 7-zip: Results.md of ThomasKaiser/sbc-bench; the last one is the one before it times 1.85, as much as its core is
# faster in sysbench (leoncode.co.uk, Raspberry Pi CPU benchmarks).
BOARDS = (
    Board("Raspberry Pi Zero 2 W", "Cortex-A53", 1.0, A53, 3030 / 4),
    Board("Raspberry Pi 3 B+", "Cortex-A53", 1.4, A53, 3670 / 4),
    Board("Raspberry Pi 4 B", "Cortex-A72", 1.8, A72, 5760 / 4),
    Board("Raspberry Pi 5", "Cortex-A76", 2.4, A76, 5760 / 4 * 1.85),
)


def step(report: Report, mips: float, board: Board, threads: int) -> float:
    """ms of a control step of the reported missions on ``board``, on average, if this machine's core has ``mips``.

    Raises KeyError when the report is not of missions.
    """
    whole = report.stages[f"{BOARD}: {STEP}"]
    towers = [report.stages[f"{BOARD}: {stage}"] for stage in TOWERS]
    here = report.stages[f"{BOARD}: {TOWERS[0]}"].mean
    in_towers = sum(stage.mean * stage.calls for stage in towers) / whole.calls
    return in_towers * board.tower(threads) / here + (whole.mean - in_towers) * mips / board.mips


def main(arguments: list[str] | None = None) -> None:
    """``vlpg bench boards``."""
    summary, details = __doc__.split(": ", 1)[1].split("\n\n", 1)
    parser = argparse.ArgumentParser(prog="vlpg bench boards", description=summary, epilog=details)
    parser.add_argument("file", type=Path, metavar="FILE", help="of vlpg bench mission --json FILE")
    mips = 'rating of a core here: the last line of "7zz b -mmt1" (package 7zip)'
    parser.add_argument("--mips", type=float, required=True, help=mips)
    options = parser.parse_args(arguments)
    if not options.mips > 0:
        parser.error("--mips must be more than 0")
    try:
        report = Report.load(options.file)
        if report.model != DEFAULT:
            raise ReportError(f"{options.file} is of the model {report.model}; only {DEFAULT} can be estimated")
        rows = [
            (board, [(board.tower(threads), step(report, options.mips, board, threads)) for threads in (1, 4)])
            for board in BOARDS
        ]
    except KeyError as error:
        parser.exit(2, f"vlpg bench boards: {options.file} has no stage {error}; make it with vlpg bench mission\n")
    except ReportError as error:
        parser.exit(2, f"vlpg bench boards: {error}\n")
    heads = f"{'a picture':>9} {'a step':>7} {'a second':>8}"
    print("ESTIMATES, not measured; good to a factor of two. Means, ms.")
    print(f"{'':33} {'one thread':>26}   {'--threads 4':>26}")
    print(f"{'board':22} {'cores':10} {heads}   {heads}")
    for board, estimates in rows:
        figures = "   ".join(f"{tower:9.0f} {whole:7.0f} {1000 / whole:8.1f}" for tower, whole in estimates)
        print(f"{board.name:22} {board.core:10} {figures}")


if __name__ == "__main__":
    main()
