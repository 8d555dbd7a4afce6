"""With the training extra installed only: PyTorch's tower runs and is a probe."""

import pytest

pytest.importorskip("torch")
pytest.importorskip("efficientnet_lite_pytorch")

from edge.bench.probe_process import ProbeProcess  # noqa: E402


def test_pytorchs_tower_is_timed_and_weighed():
    with ProbeProcess("tools.bench.peer", "torch", "64", "96") as probe:
        assert len(probe.time(2)) == 2
        assert probe.peak.pss > 100
