import io

import pytest
from rich.console import Console

from tools.demo.progress import Display, TimeLeft


def test_time_left_follows_the_pace():
    left = TimeLeft()
    for now in range(11):
        estimate = left.update(float(now), viewed=2.0 * now, area=40.0)
    assert estimate == pytest.approx(10.0)  # 20 m2 more at 2 m2/s


def test_time_left_forgets_an_old_pace():
    left = TimeLeft(window=10.0)
    for now in range(10):
        left.update(float(now), viewed=float(now), area=60.0)
    for now in range(10, 31):
        estimate = left.update(float(now), viewed=9.0 + (now - 9) * 0.5, area=60.0)
    assert estimate == pytest.approx((60.0 - 19.5) / 0.5)


def test_no_estimate_without_a_pace():
    left = TimeLeft()
    assert left.update(0.0, 0.0, 10.0) is None
    assert left.update(5.0, 0.0, 10.0) is None


def test_nothing_is_left_when_all_is_seen():
    left = TimeLeft()
    left.update(0.0, 0.0, 10.0)
    assert left.update(5.0, 11.0, 10.0) == 0.0


def test_a_log_gets_plain_lines_and_no_control_codes():
    console = Console(file=io.StringIO(), force_terminal=False)
    with Display(console, every=0.0) as display:
        display.show("mapping", "12.0 m², [3 nodes]", 0.4)
        display.say("found the teddy bear", "green")
    assert console.file.getvalue() == "mapping: 12.0 m², [3 nodes]\nfound the teddy bear\n"


def test_a_terminal_gets_a_bar():
    console = Console(file=io.StringIO(), force_terminal=True, width=100)
    with Display(console) as display:
        display.show("mapping", "12.0 m²", 0.4)
        display._progress.refresh()
    assert "━" in console.file.getvalue() and "12.0 m²" in console.file.getvalue()
