"""A process that systemd runs as ``Type=notify`` says that it is up, and that it has not hung (sd_notify(3))."""

import os
import socket
import time

PERIOD = 1.0  # s between signs of life; the unit's WatchdogSec is several times that


class Service:
    """What the service manager is told; nothing, where none listens."""

    def __init__(self):
        address = os.environ.get("NOTIFY_SOCKET", "")
        self._address = "\0" + address[1:] if address.startswith("@") else address  # an abstract one, or a path
        self._next = 0.0

    def ready(self):
        """It answers from now on."""
        self._tell("READY=1")

    def alive(self):
        """A sign of life, once it is up; to be called often."""
        if self._address and time.monotonic() >= self._next:
            self._next = time.monotonic() + PERIOD
            self._tell("READY=1\nWATCHDOG=1")  # once more: a manager that was busy has not heard the first

    def _tell(self, state):
        if not self._address:
            return
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK) as line:
                line.sendto(state.encode(), self._address)
        except OSError:  # the manager is busy, restarting or gone; a robot works without, and never waits for it
            pass
