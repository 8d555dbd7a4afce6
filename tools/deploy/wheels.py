"""The robot's wheels: resolved once for a target, locked with their hashes, fetched as locked."""

import re
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from models.manifest import sha256
from tools.deploy.target import TOKENIZERS, DeployError, Target, requirements

_LINE = re.compile(r"(?P<name>[a-z0-9-]+)==(?P<version>\S+) --hash=sha256:(?P<sha256>[0-9a-f]{64})")


@dataclass(frozen=True, slots=True)
class Locked:
    """One wheel, exactly."""

    name: str
    version: str
    sha256: str

    def __str__(self) -> str:
        return f"{self.name}=={self.version} --hash=sha256:{self.sha256}"


def resolve(target: Target) -> list[Locked]:
    """The newest wheels that satisfy setup.cfg on the target, and what they need. Raises DeployError."""
    with tempfile.TemporaryDirectory() as folder:
        wanted = requirements()
        alone = [requirement for requirement in wanted if requirement.name == TOKENIZERS]
        _download(target, folder, [str(requirement) for requirement in wanted if requirement not in alone])
        _download(target, folder, ["--no-deps", *map(str, alone)])
        return sorted((_locked(wheel) for wheel in Path(folder).glob("*.whl")), key=lambda locked: locked.name)


def write_lock(target: Target, locked: list[Locked]) -> None:
    """Replace the target's lock file."""
    target.lock.parent.mkdir(exist_ok=True)
    head = f"# The robot's dependencies on {target.name}, as resolved by: vlpg deploy lock\n"
    target.lock.write_text(head + "".join(f"{line}\n" for line in locked))


def read_lock(target: Target) -> list[Locked]:
    """What is locked. Raises DeployError when there is no lock, or it has not what setup.cfg asks for."""
    how = f"vlpg deploy lock --target {target.machine} --python {target.python}"
    try:
        lines = target.lock.read_text().splitlines()
    except FileNotFoundError:
        raise DeployError(f"nothing is locked for {target.name}; run: {how}") from None
    found = [_LINE.fullmatch(line) for line in lines if line and not line.startswith("#")]
    if not all(found):
        raise DeployError(f"{target.lock} is damaged; run: {how}")
    locked = [Locked(**match.groupdict()) for match in found]
    versions = {one.name: one.version for one in locked}
    missing = [str(one) for one in requirements() if not _satisfied(one, versions)]
    if missing:
        raise DeployError(f"the lock for {target.name} lacks {', '.join(sorted(missing))}; run: {how}")
    return locked


def fetch(target: Target, locked: list[Locked], folder: Path) -> list[Path]:
    """The wheels, from ``folder`` or else from the package index, checked by their hashes. Raises DeployError."""
    folder.mkdir(parents=True, exist_ok=True)
    there = {sha256(wheel): wheel for wheel in folder.glob("*.whl")}
    absent = [one for one in locked if one.sha256 not in there]
    if absent:
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as lines:
            lines.write("".join(f"{one}\n" for one in absent))
            lines.flush()
            _download(target, folder, ["--no-deps", "--require-hashes", "--requirement", lines.name])
        there = {sha256(wheel): wheel for wheel in folder.glob("*.whl")}
    wheels = [there[one.sha256] for one in locked]
    for wheel in wheels:
        _check_layout(wheel)
    return wheels


def _satisfied(requirement: Requirement, versions: dict[str, str]) -> bool:
    name = canonicalize_name(requirement.name)
    return name in versions and requirement.specifier.contains(versions[name], prereleases=True)


def _download(target: Target, folder, what: list[str]) -> None:
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    done = subprocess.run(
        [*command, *target.pip_options(), "--dest", str(folder), *what], capture_output=True, text=True
    )
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line.strip()] or ["pip said nothing"]
        raise DeployError(f"the wheels for {target.name} cannot be had: {said[-1]}")


def _locked(wheel: Path) -> Locked:
    name, version, *_ = wheel.name.split("-")
    return Locked(canonicalize_name(name), version, sha256(wheel))


def _check_layout(wheel: Path) -> None:
    """The installer only unpacks: files that belong elsewhere than beside each other would be lost."""
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            top, _, rest = name.partition("/")
            if top.endswith(".data") and not rest.startswith(("scripts/", "data/")):
                raise DeployError(f"{wheel.name} cannot be installed by unpacking it, because of {name}")
