import re

from tools.report.memory_chart import memory_chart
from tools.report.record import Process


def test_lines_end_at_their_last_reading_and_labels_do_not_overlap(run):
    chart = memory_chart(run.processes, 170.0)
    assert chart.count("<polyline") == 3
    heights = [float(y) for y in re.findall(r'<text x="858" y="([\d.]+)"', chart)]
    assert len(heights) == 4  # three processes and the budget
    assert all(b - a >= 15 for a, b in zip(heights, heights[1:]))


def test_too_few_readings_draw_nothing():
    assert memory_chart([Process("robot", 1.0, 1.0, 0.0, 1.0, [0.0], [1.0])], 170.0) == ""
