"""A target whose locked wheels are two small ones of our own."""

import zipfile

import pytest
from packaging.requirements import Requirement

from models.manifest import Manifest, resolve, sha256
from tools.deploy import target, wheels
from tools.deploy.bundle import BundleConfig
from tools.deploy.target import Target


def make_wheel(folder, name, content="answer = 42\n", extra=None):
    path = folder / f"{name}-1.0-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        files = {f"{name}/__init__.py": content, f"{name}-1.0.dist-info/METADATA": "", **(extra or {})}
        for file, text in files.items():
            archive.writestr(zipfile.ZipInfo(file), text)
    return path


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The folder that already has the wheels, and is all that the lock asks for."""
    folder = tmp_path / "cache"
    folder.mkdir()
    made = [make_wheel(folder, name) for name in ("speed", "tokenizers")]
    monkeypatch.setattr(target, "LOCKS", tmp_path / "locks")
    monkeypatch.setattr(wheels, "requirements", lambda: [Requirement("speed>=1"), Requirement("tokenizers")])
    wheels.write_lock(Target(), [wheels.Locked(path.name.split("-")[0], "1.0", sha256(path)) for path in made])
    return folder


@pytest.fixture(scope="session")
def model():
    return Manifest.load(resolve())


@pytest.fixture
def config(model):
    return BundleConfig(Target(), model)
