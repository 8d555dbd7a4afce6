import os

from tools.demo.machine import machine, versions


def test_names_processor_cores_and_memory():
    facts = machine()
    assert f"{len(os.sched_getaffinity(0))} core" in facts["processor"]
    assert float(facts["memory"].removesuffix(" GB")) > 0.1
    assert facts["system"].startswith("Linux")


def test_states_the_versions_that_matter():
    assert {"python", "vlpg-edge", "numpy", "eclipse-zenoh"} <= versions().keys()
