"""Streams: publishers that never wait for a slow reader, and subscribers that keep only the newest samples."""

import time
from collections import deque

import zenoh

from edge.link.messages import decode, encode


def publisher(session, key, command=False):
    """A publisher on ``key``. Streams are dropped under congestion; a ``command`` blocks, since it must arrive."""
    control = zenoh.CongestionControl.BLOCK if command else zenoh.CongestionControl.DROP
    priority = zenoh.Priority.REAL_TIME if command else zenoh.Priority.DATA
    return Publisher(session.declare_publisher(key, congestion_control=control, priority=priority, express=command))


class Publisher:
    """Sends messages in CDR."""

    def __init__(self, publisher):
        self._publisher = publisher

    def put(self, message):
        """Encodes and sends. Returns without waiting when the stream is congested and the sample is dropped."""
        self._publisher.put(encode(message))


class Topic:
    """The newest samples on one key. The zenoh callback only hands them over; decoding happens where they are read."""

    def __init__(self, session, key, kind, keep=1, wake=None):
        """``kind``: message type. ``keep``: how many samples. ``wake``: called (fast!) when one arrives."""
        self._kind, self._wake = kind, wake
        self._samples = deque(maxlen=keep)  # payloads; append and popleft are atomic
        self._arrival = -float("inf")
        self._decoded = (None, None)  # the payload last read, and its message
        # Called in zenoh's receiving thread: a queue and a thread for each topic would grow when Python is slow.
        callback = zenoh.handlers.Callback(self._take, indirect=False)
        self._subscriber = session.declare_subscriber(key, callback)

    def _take(self, sample):
        self._arrival = time.monotonic()
        self._samples.append(sample.payload)
        if self._wake is not None:
            self._wake()

    @property
    def age(self):
        """Seconds since the newest sample arrived; inf when none has."""
        return time.monotonic() - self._arrival

    def read_latest(self):
        """The newest message, or None before the first. Raises MessageError when it is not of the topic's type."""
        try:
            payload = self._samples[-1]
        except IndexError:
            return None
        if self._decoded[0] is not payload:
            self._decoded = (payload, decode(self._kind, payload.to_bytes()))
        return self._decoded[1]

    def take(self):
        """The payloads (bytes) that arrived since the last call, oldest first, at most ``keep``."""
        payloads = []
        while self._samples:
            payloads.append(self._samples.popleft().to_bytes())
        return payloads
