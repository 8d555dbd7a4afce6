"""What systemd would hear, on a socket of our own."""

import socket

import pytest

from edge.service import Service


@pytest.fixture(params=["path", "abstract"])
def manager(request, tmp_path, monkeypatch):
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    name = str(tmp_path / "notify") if request.param == "path" else f"@vlpg-test-{tmp_path}"
    listener.bind(name.replace("@", "\0", 1) if name.startswith("@") else name)
    listener.settimeout(5)
    monkeypatch.setenv("NOTIFY_SOCKET", name)
    yield listener
    listener.close()


def test_it_tells_that_it_is_up_and_then_at_most_once_a_second_that_it_lives(manager):
    service = Service()
    service.ready()
    for _ in range(50):
        service.alive()
    assert [manager.recv(100), manager.recv(100)] == [b"READY=1", b"READY=1\nWATCHDOG=1"]
    manager.setblocking(False)
    with pytest.raises(BlockingIOError):
        manager.recv(100)


def test_a_manager_that_is_gone_does_no_harm(manager):
    service = Service()
    manager.close()
    service.ready()
    service.alive()


def test_a_manager_that_does_not_listen_is_not_waited_for(manager):
    service = Service()
    for _ in range(10_000):  # more than its socket holds
        service.ready()


def test_without_a_manager_nothing_is_said(monkeypatch):
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    service = Service()
    service.ready()
    service.alive()
