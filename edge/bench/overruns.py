"""What a report spends beyond a board's budget."""

from edge.bench.report import STEP, Report
from edge.budget import Budget

BOARD, HOST = "mission", "mission, text on the host"  # subjects of the report
PERIOD = 100.0  # ms between control steps


def spent(report: Report, budget: Budget) -> list[tuple[str, float, float, str]]:
    """What of the report the ``budget`` limits: its name, value, limit and unit."""
    spent = []
    for name, limit in ((BOARD, budget.peak(text=True)), (HOST, budget.peak(text=False))):
        if name in report.processes:
            spent.append((f"{name}: peak PSS", report.processes[name].peak, limit, "MB"))
    for name, size in report.sizes.items():
        if name.startswith("store: "):
            spent.append((name, size, budget.ram if name.endswith("RAM") else budget.disk, "MB"))
    for name, stage in report.stages.items():
        if name.endswith(STEP):
            spent.append((f"{name}: p95", stage.p95, budget.step, "ms"))
            spent.append((f"{name}: of a core at 10 Hz", 100 * stage.mean / PERIOD, budget.core, "%"))
    return spent


def overruns(report: Report, budget: Budget) -> list[str]:
    """A sentence on each figure over the ``budget``."""
    figures = spent(report, budget)
    return [f"{name} is {value:.1f} {unit}, over {limit:g}" for name, value, limit, unit in figures if value > limit]
