"""What kind of board a bundle is for."""

import configparser
from dataclasses import dataclass
from pathlib import Path

from packaging.requirements import Requirement

MACHINES = ("aarch64", "x86_64")
PYTHONS = ("3.11", "3.13")
LOCKS = Path(__file__).parent / "locks"
SETUP = Path(__file__).parents[2] / "setup.cfg"
# glibc of the oldest system that all wheels run on: 2.28, Debian 10 and later
_GLIBC = ("2014", "_2_17", "_2_24", "_2_27", "_2_28")

# Only the text tower uses it. What it declares to need itself is for downloads from a hub, which a robot does not do.
TOKENIZERS = "tokenizers"


class DeployError(RuntimeError):
    """A bundle cannot be made; the message says why and what to do."""


@dataclass(frozen=True)
class Target:
    """A processor architecture and a version of CPython."""

    machine: str = "aarch64"
    python: str = "3.11"

    @property
    def name(self) -> str:
        return f"{self.machine}-cp{self._tag}"

    @property
    def lock(self) -> Path:
        """The file of exact versions and hashes."""
        return LOCKS / f"{self.name}.txt"

    def pip_options(self) -> list[str]:
        """What makes pip choose wheels for the target rather than for here."""
        platforms = [option for glibc in _GLIBC for option in ("--platform", f"manylinux{glibc}_{self.machine}")]
        abis = [option for abi in (f"cp{self._tag}", "abi3", "none") for option in ("--abi", abi)]
        python = ["--python-version", self._tag, "--implementation", "cp"]
        return ["--only-binary=:all:", *platforms, *python, *abis]

    @property
    def _tag(self) -> str:
        return self.python.replace(".", "")


def requirements() -> list[Requirement]:
    """What the robot needs, from setup.cfg. Raises DeployError outside of a clone."""
    lines = _setup()["options"]["install_requires"].splitlines()
    return [Requirement(line) for line in lines if line.strip() and not line.strip().startswith("#")]


def version() -> str:
    """The project's, from setup.cfg. Raises DeployError outside of a clone."""
    return _setup()["metadata"]["version"]


def _setup() -> configparser.ConfigParser:
    setup = configparser.ConfigParser()
    if not setup.read(SETUP):
        raise DeployError("there is no setup.cfg; run vlpg deploy from a clone of the project")
    return setup
