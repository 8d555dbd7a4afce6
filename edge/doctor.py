"""``vlpg doctor``: can this machine run the robot? Each check says what it found and, if that is bad, what to do."""

import argparse
import os
import platform
import shutil
import sqlite3
import statistics
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of
from itertools import chain
from pathlib import Path

from edge.budget import allowance
from edge.process import pss

PACKAGES = ("numpy", "onnxruntime", "opencv-python-headless", "eclipse-zenoh", "pycdr2", "msgspec", "nlopt", "numkong")
# What int8 products gain from, as the kernel names it: ARM's and Intel's.
FEATURES = ("asimddp", "i8mm", "sve", "avx2", "avx_vnni", "avx512_vnni", "amx_int8")
NEEDED = {"asimd", "avx2"}  # one of them; without, ONNX Runtime's int8 is slower than float32
FREE_DISK = 100.0  # MB: memories of homes, and logs
REINSTALL = "install the robot again: install.sh, or pip install ."
PASSES = 20  # of the image tower, for its time
STEP, TOO_LONG = 100.0, 1000.0  # ms: a control step; with pictures that take longer nobody would call it driving
PARITY_SLACK = 0.005  # cosine that int8 kernels of other processors may differ by
PATIENCE = 3.0  # s for the others to be heard
CGROUPS = Path("/sys/fs/cgroup")


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at. Without a ``remedy`` it is good."""

    subject: str
    found: str
    remedy: str = ""

    def __str__(self):
        verdict = f"BAD   {self.remedy}" if self.remedy else "ok"
        return f"{self.subject:12} {self.found:60} {verdict}".rstrip()


def machine(text: bool) -> Iterator[Finding]:
    """Processor, memory, disk and the settings of this process; whether a robot with or without a text tower fits."""
    python = f"Python {platform.python_version()} on {platform.machine()}, {os.cpu_count()} cores"
    old = sys.version_info < (3, 11)
    yield Finding("python", python, "install Python 3.11 or newer" if old else "")
    flags = _cpu_flags()
    helpful = [name for name in FEATURES if name in flags] or ["none of those that speed int8 up"]
    slow = flags and not NEEDED & flags
    yield Finding("processor", ", ".join(helpful), "expect seconds a picture; use a newer board" if slow else "")
    free, needed = _free_memory(), allowance(text)
    remedy = f"free {needed:.0f} MB{', or use --offload host' if text else ''}" if 0 < free < needed else ""
    yield Finding("memory", f"{free:.0f} MB available, what an installed robot takes included", remedy)
    controllers = CGROUPS / "cgroup.controllers"
    if controllers.is_file() and "memory" not in controllers.read_text().split():
        remedy = "add cgroup_enable=memory to the kernel's command line, in cmdline.txt on a Raspberry Pi"
        yield Finding("memory limit", "the kernel does not keep the service's MemoryMax", remedy)
    disk = shutil.disk_usage(Path(__file__).parent).free / 1e6
    yield Finding("disk", f"{disk:.0f} MB free", f"free {FREE_DISK:.0f} MB" if disk < FREE_DISK else "")
    for name in ("ORT_DISABLE_TELEMETRY", "OPENBLAS_NUM_THREADS"):
        value = os.environ.get(name, "")
        remedy = "" if value == "1" else f"export {name}=1, as the installed vlpg-robot and the vlpg command do"
        yield Finding("setting", f"{name}={value}", remedy)
    year = time.gmtime().tm_year  # a board without a battery for its clock wakes up in the past
    yield Finding("clock", time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()), "set the clock" if year < 2026 else "")


def packages(text: bool) -> Iterator[Finding]:
    """Versions of what the robot imports, with or without its text tower."""
    for name in (*PACKAGES, "tokenizers") if text else PACKAGES:
        try:
            yield Finding("package", f"{name} {version_of(name)}")
        except PackageNotFoundError:
            yield Finding("package", f"{name} is missing", REINSTALL)


def model(name: str | None, text: bool) -> Iterator[Finding]:
    """Are the weights whole, do they mean here what they meant where they were made, and how fast are they?"""
    import cv2
    import numpy as np

    from edge.perception.encoder import Encoder
    from models.manifest import Manifest, ModelError, resolve

    try:
        manifest = Manifest.load(resolve(name) if name else resolve())
        manifest.verify(text)
    except ModelError as error:
        yield Finding("model", "not whole", str(error))
        return
    yield Finding("model", f"{manifest.name}, {manifest.dim}-d, {'with' if text else 'without'} text tower")
    encoder = Encoder(manifest, text)
    reference = manifest.folder / "reference.npz"
    if not reference.is_file():
        yield Finding("image tower", "the model has no reference.npz to compare with")
        return
    with np.load(reference) as known:
        jpegs, images, prompts, texts = (known[key] for key in ("jpegs", "image", "prompts", "text"))
        ends = np.cumsum(known["lengths"])
    pictures = [cv2.imdecode(part, cv2.IMREAD_COLOR)[..., ::-1] for part in np.split(jpegs, ends[:-1])]
    alike = [np.sum(encoder.encode_image(rgb).vectors * want, axis=1) for rgb, want in zip(pictures, images)]
    yield _parity("image tower", float(np.median(alike)), manifest.measured.get("image_parity"))
    times = []
    for _ in range(PASSES):
        started = time.perf_counter()
        encoder.encode_image(pictures[0])
        times.append(1000 * (time.perf_counter() - started))
    took = statistics.median(times)
    slow = f", over a control step of {STEP:.0f}: it steers less often" if took > STEP else ""
    yield Finding(
        "image tower",
        f"{took:.1f} ms a picture{slow}",
        "use a smaller model or a faster board" if took > TOO_LONG else "",
    )
    if text:
        alike = np.sum(encoder.encode_text(prompts.tolist()) * texts, axis=1)
        yield _parity("text tower", float(np.median(alike)), manifest.measured.get("text_parity"))
    yield Finding("memory", f"{pss():.0f} MB PSS with the towers open")


def store(path: Path, digest: str | None) -> Iterator[Finding]:
    """Is a home's memory whole, and this model's? It is only read."""
    if not path.is_file():
        yield Finding("store", f"{path} does not exist", "map the home first, or correct --memory")
        return
    if not os.access(path, os.R_OK):
        yield Finding("store", f"{path} is not yours to read", "run the doctor with sudo")
        return
    from edge.memory.database import READABLE, unusable

    try:
        db = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
        try:
            damage = db.execute("PRAGMA quick_check(1)").fetchone()[0]
            meta = dict(db.execute("SELECT key, value FROM meta"))
            nodes = db.execute("SELECT count(*) FROM node WHERE superseded_by IS NULL").fetchone()[0]
        finally:
            db.close()
    except sqlite3.Error as error:
        yield Finding("store", "cannot be read", str(unusable(path, error)))
        return
    other = digest is not None and meta.get("digest") != digest
    remedy = f"it is {meta.get('encoder')}'s; run vlpg reindex {path}, on a board vlpg-reindex" if other else ""
    if meta.get("schema") not in READABLE:
        remedy = (
            f"its schema is {meta.get('schema')}; use the version that made it, or the older copy beside it, *.schema-N"
        )
    if damage != "ok":
        remedy = f"it is damaged ({damage}); restore it from a copy, or map the home again"
    size = path.stat().st_size / 1e6
    yield Finding("store", f"{path}: {nodes} nodes of {meta.get('encoder')}, {size:.1f} MB", remedy)


def link(config, name: str, offload: bool) -> Iterator[Finding]:
    """Does the base speak, and is a host there if one is needed?"""
    from edge.link import messages
    from edge.link.alive import Watch
    from edge.link.session import LinkError, open_session
    from edge.link.topic import Topic

    try:
        session = open_session(config)
    except LinkError as error:
        yield Finding("link", "no session", str(error))
        return
    with session:
        heard = threading.Event()
        odometry = Topic(session, f"{name}/odom", messages.Odometry, wake=heard.set)
        host = Watch(session, "host/alive/*")
        heard.wait(PATIENCE)
        silent = odometry.age == float("inf")
        found = f"no odometry on {name}/odom" if silent else f"odometry on {name}/odom"
        yield Finding("base", found, "start the base, or its bridge" if silent else "")
        there = host.wait(bool, 0.0 if not offload else PATIENCE)
        remedy = "start vlpg host" if offload and not there else ""
        yield Finding("host", "alive" if there else "not heard", remedy)


def _options(arguments):
    from edge.link.session import add_link_arguments, key_root

    parser = argparse.ArgumentParser(prog="vlpg doctor", description="Can this machine run the robot?")
    parser.add_argument("--name", type=key_root, default="robot1", help="key root of the robot (default: %(default)s)")
    parser.add_argument("--memory", type=Path, metavar="FILE", help="also check this store")
    parser.add_argument("--model", help="name or folder of the encoder (default: the shipped one)")
    parser.add_argument("--offload", choices=["host", "never", "auto"], default="auto", help="who encodes text")
    parser.add_argument("--no-link", action="store_true", help="do not look for the base and a host")
    add_link_arguments(parser)
    return parser.parse_args(arguments)


def _everything(arguments) -> Iterator[Finding]:
    try:
        options = _options(arguments)
    except ImportError as error:  # the command line itself needs what is missing
        yield from chain(machine(True), packages(True), [_unseen(error)])
        return
    text = options.offload != "host"
    yield from chain(machine(text), packages(text))
    try:
        from edge.link.session import link_config

        yield from model(options.model, text)
        if options.memory:
            yield from store(options.memory, _digest(options.model))
        if not options.no_link:
            yield from link(link_config(options), options.name, not text)
    except ImportError as error:
        yield _unseen(error)


def _unseen(error: ImportError) -> Finding:
    return Finding("the rest", f"cannot be looked at: {' '.join(str(error).split())}", REINSTALL)


def main(arguments=None):
    """``python -m edge.doctor``. Exit code 1: something is bad."""
    bad = 0
    try:
        for finding in _everything(arguments):
            bad += bool(finding.remedy)
            print(finding, flush=True)
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    raise SystemExit(1 if bad else 0)


def _parity(subject: str, cosine: float, stated: float | None) -> Finding:
    low = stated is not None and not cosine >= stated - PARITY_SLACK  # nor is NaN
    remedy = f"the manifest says {stated:g}: report this processor with its ONNX Runtime" if low else ""
    return Finding(subject, f"cosine {cosine:.4f} to float32", remedy)


def _digest(name: str | None) -> str | None:
    from models.manifest import Manifest, ModelError, resolve

    try:
        return Manifest.load(resolve(name) if name else resolve()).digest
    except ModelError:
        return None  # the model check says so


def _cpu_flags() -> set[str]:
    """What the kernel says that the processor can do; empty where it does not."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return set()
    return {flag for line in lines if line.startswith(("flags", "Features")) for flag in line.split(":", 1)[1].split()}


def _free_memory() -> float:
    """MB that a robot can have: what is available, and what the installed one has for itself already."""
    processes = CGROUPS / "system.slice" / "vlpg-robot.service" / "cgroup.procs"
    pids = processes.read_text().split() if processes.is_file() else []
    return _available() + sum(_kilobytes(Path("/proc", pid, "status"), "RssAnon:") for pid in pids) * 1024 / 1e6


def _available() -> float:
    """MB that processes can have without swapping; 0 where the kernel does not tell."""
    return _kilobytes(Path("/proc/meminfo"), "MemAvailable:") * 1024 / 1e6


def _kilobytes(file: Path, name: str) -> int:
    try:
        lines = file.read_text().splitlines()
    except OSError:
        return 0
    return sum(int(line.split()[1]) for line in lines if line.startswith(name))


if __name__ == "__main__":
    main()
