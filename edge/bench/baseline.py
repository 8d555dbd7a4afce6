"""What became slower or larger than an earlier report says."""

from edge.bench.report import Report, ReportError

SLOWER = 0.15  # share of a median by which it may grow unnoticed: between runs, machines differ from themselves
LARGER = 0.03  # share of a size
LITTLE = 0.05  # ms; stages that grow by less are not told


def regressions(now: Report, before: Report) -> list[str]:
    """A sentence on each figure that grew by more than the margin; latencies also by more than both intervals.

    What only one of them has is not compared. Raises ReportError when that is all.
    """
    figures = [{*report.stages, *report.processes, *report.sizes} for report in (now, before)]
    if figures[0].isdisjoint(figures[1]):
        raise ReportError("the earlier report has nothing of what was measured now: it is of other parts of the robot")
    found = []
    for name, stage in now.stages.items():
        if old := before.stages.get(name):
            margin = max(SLOWER * old.p50, stage.interval + old.interval, LITTLE)
            if stage.p50 > old.p50 + margin:
                found.append(f"{name} takes {stage.p50:.2f} ms, was {old.p50:.2f}")
    for name, process in now.processes.items():
        if (old := before.processes.get(name)) and process.peak > old.peak * (1 + LARGER):
            found.append(f"{name}: peak PSS is {process.peak:.1f} MB, was {old.peak:.1f}")
    for name, size in now.sizes.items():
        if name in before.sizes and size > before.sizes[name] * (1 + LARGER):
            found.append(f"{name} is {size:.2f} MB, was {before.sizes[name]:.2f}")
    return found
