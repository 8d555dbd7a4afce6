"""On what a run was made: figures mean little without it."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("vlpg-edge", "numpy", "onnxruntime", "opencv-python-headless", "eclipse-zenoh", "pymunk")


def machine() -> dict[str, str]:
    """Processor, cores that may be used, memory and system, in words."""
    cores = len(os.sched_getaffinity(0))
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    return {
        "processor": f"{_processor()}, {cores} core{'s' * (cores != 1)}",
        "memory": f"{memory:.1f} GB",
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
    }


def versions() -> dict[str, str]:
    """Version of Python and of the installed packages that matter."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    # ARM boards have no "model name"; some state the board as "Model" or the chip as "Hardware".
    for wanted in ("model name", "Model", "Hardware"):
        for line in lines:
            if line.startswith(wanted) and ":" in line:
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()
