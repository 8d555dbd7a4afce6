"""PSS of the processes over the run, as inline SVG."""

from html import escape
from math import ceil

from tools.report.record import Process

_WIDTH, _HEIGHT = 1000, 240
_LEFT, _RIGHT, _TOP, _BOTTOM = 44, 150, 12, 26
_APART = 15  # px between labels of two lines


def memory_chart(processes: list[Process], budget: float) -> str:
    """Lines with their names at the end, and the robot's ``budget`` [MB]; nothing without two readings."""
    shown = [process for process in processes if len(process.times) > 1]
    if not shown:
        return ""
    end = max(process.times[-1] for process in shown)
    highest = max([budget, *(max(process.pss) for process in shown)])
    top = 50 * ceil(highest * 1.05 / 50)

    def x(seconds):
        return _LEFT + (_WIDTH - _LEFT - _RIGHT) * seconds / end

    def y(megabytes):
        return _TOP + (_HEIGHT - _TOP - _BOTTOM) * (1 - megabytes / top)

    parts = []
    for megabytes in range(0, top + 1, 50):
        line = f'y1="{y(megabytes):.1f}" y2="{y(megabytes):.1f}"'
        parts.append(f'<line class="axis" x1="{_LEFT}" x2="{_WIDTH - _RIGHT}" {line}/>')
        parts.append(f'<text x="{_LEFT - 8}" y="{y(megabytes) + 4:.1f}" text-anchor="end">{megabytes}</text>')
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        parts.append(
            f'<text x="{x(share * end):.1f}" y="{_HEIGHT - 6}" text-anchor="middle">{share * end:.0f} s</text>'
        )
    line = f'y1="{y(budget):.1f}" y2="{y(budget):.1f}"'
    parts.append(f'<line class="budget" x1="{_LEFT}" x2="{_WIDTH - _RIGHT}" {line}/>')
    labels = [(y(budget), f"robot's budget {budget:.0f} MB")]
    for number, process in enumerate(shown):
        points = " ".join(f"{x(t):.1f},{y(p):.1f}" for t, p in zip(process.times, process.pss))
        parts.append(f'<polyline class="s{number % 3}" points="{points}"/>')
        labels.append((y(process.pss[-1]), process.name))
    below = -_APART
    for height, name in sorted(labels):
        below = max(height, below + _APART)
        parts.append(f'<text x="{_WIDTH - _RIGHT + 8}" y="{below + 4:.1f}">{escape(name)}</text>')
    title = "PSS in MB of each process over wall time"
    return f'<svg class="chart" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{title}">{"".join(parts)}</svg>'
