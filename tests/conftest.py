"""Two zenoh sessions on the loopback interface that see nobody but each other."""

import socket

import pytest


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
