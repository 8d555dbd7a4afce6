"""What a board can spare, and what was spent beyond it."""

from dataclasses import dataclass

from edge.bench.report import STEP, Report

BOARD, HOST = "mission", "mission, text on the host"  # subjects of the report


@dataclass(frozen=True)
class Budget:
    """Limits. What a report does not have is not judged."""

    board: float  # MB peak PSS, everything on board
    host: float  # MB peak PSS, text on a host
    ram: float = 1.5  # MB, the memory of 2 000 nodes of one 512-d vector
    disk: float = 2.5  # MB, the same in its file
    step: float = 100.0  # ms, perception and planning in 95 of 100 control steps: one control period


BUDGETS = {
    "pi-zero-2w": Budget(board=170.0, host=130.0),  # 512 MB, of which the system takes half
    "qcs605": Budget(board=256.0, host=200.0),  # 2 GB, the board of [V]
}


def spent(report: Report, budget: Budget) -> list[tuple[str, float, float, str]]:
    """What of the report the ``budget`` limits: its name, value, limit and unit."""
    spent = []
    for name, limit in ((BOARD, budget.board), (HOST, budget.host)):
        if name in report.processes:
            spent.append((f"{name}: peak PSS", report.processes[name].peak, limit, "MB"))
    for name, size in report.sizes.items():
        if name.startswith("store: "):
            spent.append((name, size, budget.ram if name.endswith("RAM") else budget.disk, "MB"))
    for name, stage in report.stages.items():
        if name.endswith(STEP):
            spent.append((f"{name}: p95", stage.p95, budget.step, "ms"))
    return spent


def overruns(report: Report, budget: Budget) -> list[str]:
    """A sentence on each figure over the ``budget``."""
    figures = spent(report, budget)
    return [f"{name} is {value:.1f} {unit}, over {limit:g}" for name, value, limit, unit in figures if value > limit]
