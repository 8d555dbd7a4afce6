import re
from math import cos, sin

import pytest

from tools.report.plan import FloorPlan


def test_the_map_lies_over_the_house(run, tmp_path):
    """The image's matrix takes a grid cell where the robot's frame, placed at the true start, puts it."""
    plan = FloorPlan(run, tmp_path)
    matrix = re.search(r"matrix\(([^)]*)\)", plan.defs()).group(1)
    a, b, c, d, e, f = map(float, matrix.split())
    x0, y0, theta = run.home.start
    for row, col in ((0, 0), (0, 100), (160, 0), (37, 81)):
        x = run.map.origin[0] + col * run.map.resolution
        y = run.map.origin[1] + row * run.map.resolution
        house = (x0 + cos(theta) * x - sin(theta) * y, y0 + sin(theta) * x + cos(theta) * y)
        # The plan's corner: 0.3 m left of and above the house's (0, 5).
        assert (a * col + c * row + e, b * col + d * row + f) == pytest.approx(
            (house[0] + 0.3, 5.3 - house[1]), abs=2e-3
        )


def test_the_overview_has_a_tick_for_each_node_and_a_mark_for_each_answer(run, tmp_path):
    overview = FloorPlan(run, tmp_path).overview()
    assert overview.count('class="node"') == len(run.nodes)
    assert overview.count('class="said"') == 2
    assert overview.count('class="true"') == 2
    assert overview.count('class="answer wrong"') == 1


def test_a_search_shows_each_viewpoint_and_the_views_behind_it(run, search, tmp_path):
    drawn = FloorPlan(run, tmp_path).search(search, 1)
    assert drawn.count('class="viewpoint best"') == 1
    assert drawn.count('class="viewpoint other"') == 1
    assert drawn.count('class="member best"') == 3
