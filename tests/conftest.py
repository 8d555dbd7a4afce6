"""Two zenoh sessions on the loopback interface that see nobody but each other, and a cache that is nobody's."""

import socket

import pytest


@pytest.fixture(autouse=True)
def nobodys_cache(tmp_path, monkeypatch):
    """No test, and no process that it starts, reads or writes the user's cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def endpoint():
    """A TCP endpoint of the loopback interface that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@pytest.fixture
def sessions(endpoint):
    """A session that listens, and one that is connected to it."""
    from edge.link.session import LinkConfig, open_session

    with (
        open_session(LinkConfig(listen=(endpoint,), multicast_scouting=False)) as listening,
        open_session(LinkConfig(connect=(endpoint,), multicast_scouting=False)) as connected,
    ):
        yield listening, connected
