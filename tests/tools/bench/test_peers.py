"""Side by side: the same program twice is as fast and as large as itself."""

import pytest

from models.manifest import resolve
from tools.bench.peers import measure, show

OURS = ("tools.models.probe", "image", str(resolve()))


def test_each_peer_is_timed_and_weighed():
    ours, again = measure({"ours": OURS, "again": OURS}, turns=12)
    assert (ours.name, ours.ratio, again.name) == ("ours", 1.0, "again")
    assert again.ratio == pytest.approx(1.0, abs=0.5)  # turn by turn on one core
    assert again.peak == pytest.approx(ours.peak, rel=0.1)
    assert ours.p10 <= ours.p50 <= ours.p90
    assert ours.peak == pytest.approx(ours.anonymous + ours.file_backed, abs=1)
    assert show([ours, again]).count("\n") == 2
