"""Liveliness: every process declares a token, and notices at once when another dies."""

import threading

import zenoh


def declare_alive(session, key):
    """Declares that this process lives, e.g. ``robot1/alive/edge``; keep the token until it does not."""
    return session.liveliness().declare_token(key)


class Watch:
    """The tokens that match a key expression, e.g. ``host/alive/*``, kept up to date."""

    def __init__(self, session, expression):
        self._alive = set()
        self._changed = threading.Condition()
        callback = zenoh.handlers.Callback(self._update, indirect=False)
        self._subscriber = session.liveliness().declare_subscriber(expression, callback, history=True)

    def _update(self, sample):
        with self._changed:
            if sample.kind == zenoh.SampleKind.PUT:
                self._alive.add(str(sample.key_expr))
            else:
                self._alive.discard(str(sample.key_expr))
            self._changed.notify_all()

    @property
    def alive(self):
        """Keys of the living, a frozenset."""
        with self._changed:
            return frozenset(self._alive)

    def wait(self, condition, timeout):
        """Waits until ``condition(alive)`` is true; whether it came true within ``timeout`` seconds."""
        with self._changed:
            return self._changed.wait_for(lambda: condition(frozenset(self._alive)), timeout)
