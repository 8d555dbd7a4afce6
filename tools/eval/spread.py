"""The homes of an evaluation, spread over processes or a cluster, and resumed where it stopped."""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, replace
from hashlib import sha256
from math import isfinite
from multiprocessing import get_context
from pathlib import Path
from typing import Protocol

from firmware_sim.home import load_home
from models.manifest import Manifest, resolve

ROOT = Path(__file__).parents[2]
CODE = "edge", "firmware_sim", "models", "tools/eval"  # whose modules decide what is found


class Plan(Protocol):
    """What is done in each home."""

    encoder: str  # a model's name, or "oracle"

    def run(self, home: str):
        """A dataclass of what was found in one home: a name, a file, "generated:7"."""

    def read(self, raw: dict):
        """What ``run`` returned, from its ``asdict``."""

    def columns(self) -> list[str]:
        """What an episode tells; results that tell something else are not taken for these."""


def run_homes(
    homes: list[str],
    plan: Plan,
    jobs: int,
    folder: Path | None = None,
    cluster: str | None = None,
    tell: Callable[[str], None] = print,
) -> Iterator:
    """Results as they come, from ``jobs`` processes or from the Ray ``cluster`` at that address.

    With a ``folder`` each is kept there, and what is there already is not run again; ``tell`` is told how much of that
    other code has found.
    """
    code = digest_of_code()
    files = {home: folder and folder / _file(home, plan) for home in homes}
    kept = {home: json.loads(file.read_text()) for home, file in files.items() if file and file.exists()}
    others = sum(raw.get("code") != code for raw in kept.values())
    if others:
        tell(f"{others} of {len(kept)} homes kept in {folder} are of other code than this; another folder asks anew")
    for raw in kept.values():
        yield _read(raw, plan)
    todo = [(home, file) for home, file in files.items() if home not in kept]
    for result, file in _on_ray(todo, plan, cluster) if cluster else _here(todo, plan, jobs):
        if file:
            save(result, file, code)
        yield result


def digest_of_code() -> str:
    """Of the modules on which results depend, as they are now."""
    digest = sha256()
    for module in sorted(module for folder in CODE for module in (ROOT / folder).rglob("*.py")):
        digest.update(f"{module.relative_to(ROOT)}\n".encode() + module.read_bytes())
    return digest.hexdigest()[:12]


def _run(plan: Plan, home: str):
    import cv2

    cv2.setNumThreads(1)  # a fork does not carry OpenCV's threads along
    return plan.run(home)


def _here(todo, plan: Plan, jobs: int):
    # Fresh processes rather than forks: each home may fork its own children, and should start with one thread.
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        files, over = {pool.submit(_run, plan, home): file for home, file in todo}, set()
        try:
            for future in as_completed(files):
                over.add(future)
                yield future.result(), files[future]
        except Exception:  # a home failed: what is under way is kept, the rest is not begun
            begun = [future for future in files if future not in over and not future.cancel()]
            for future in as_completed(begun):
                if future.exception() is None:
                    yield future.result(), files[future]
            raise
        except BaseException:  # Ctrl-C: the others need not be waited for
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _on_ray(todo, plan: Plan, address: str):
    import ray  # late: an extra of its own

    ray.init(address=address, log_to_driver=False)
    # Ray's workers have threads, and a fork would copy their locks: each home gets a process of its own there.
    task = ray.remote(num_cpus=1)(lambda home: next(_here([(home, None)], plan, 1))[0])
    files = {task.remote(home): file for home, file in todo}
    while files:
        (done, *_), _ = ray.wait(list(files))
        yield ray.get(done), files.pop(done)


def save(result, file: Path, code: str) -> None:
    """Written whole or not at all, with the digest of the ``code`` that found it."""
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_suffix(".part")
    partial.write_text(json.dumps({"code": code} | asdict(result), separators=(",", ":")) + "\n")
    partial.rename(file)


def load(file: Path, plan: Plan):
    """What ``save`` wrote."""
    return _read(json.loads(file.read_text()), plan)


def _read(raw: dict, plan: Plan):
    raw.pop("code", None)  # older files have none
    return plan.read(raw)


def write(results: list, rows: list, file: Path) -> None:
    """The table's ``rows`` and all results in one file; what is not finite is null, as JSON has no word for it."""
    found = {"table": [asdict(row) for row in rows], "homes": [asdict(result) for result in results]}
    file.write_text(json.dumps(_finite(found), indent=1, allow_nan=False) + "\n")


def _finite(value):
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def _file(home: str, plan: Plan) -> str:
    """A name that tells plans, encoders and states of a home apart, so that one folder serves several.

    Raises HouseError when there is no such home.
    """
    manifest = None if plan.encoder == "oracle" else Manifest.load(resolve(plan.encoder))
    encoder = manifest and replace(manifest, folder=Path(), measured={})  # wherever it lies, and however fast it is
    asked = plan, encoder, load_home(home).to_dict(), plan.columns()
    code = sha256(repr(asked).encode()).hexdigest()[:8]
    return f"{Path(home).stem.replace(':', '-')}.{Path(plan.encoder).name}.{code}.json"
