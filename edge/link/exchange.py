"""Asking and answering over zenoh's queries."""

import logging
import queue
import time

import zenoh

from edge.link.requests import Refusal, RequestError, pack, unpack

log = logging.getLogger(__name__)

_NO_FIELDS = b"\x80"  # an empty MessagePack map: a query without a body asks with all defaults


class NoAnswer(RuntimeError):
    """Nobody answered in time."""


def ask(session, key, request, reply_kind, timeout):
    """Sends ``request`` to ``key`` and waits for the reply, a struct of ``reply_kind``.

    Raises:
        RequestError: the other side refused; the message is its own.
        NoAnswer: nobody serves the key, or not within ``timeout`` seconds.
    """
    started = time.monotonic()
    for reply in session.get(key, payload=pack(request), timeout=timeout):
        if reply.ok is not None:
            return unpack(reply_kind, reply.ok.payload.to_bytes())
        body = reply.err.payload.to_bytes()
        try:
            refusal = unpack(Refusal, body)
        except RequestError:  # zenoh's own, e.g. "Timeout"
            continue
        raise RequestError(refusal.message, refusal.field)
    waited = time.monotonic() - started
    if waited < timeout:  # zenoh knows of nobody else whom to wait for
        raise NoAnswer(f"nobody serves {key}; is it running, and do --connect and --listen agree?")
    raise NoAnswer(f"no answer from {key} within {timeout:g} s; it may be busy, or gone")


class Exchange:
    """One request that waits for its reply. Answer it once, from any thread."""

    def __init__(self, query, kind):
        self._query, self._kind = query, kind
        self.request = None

    def validate(self):
        """Decodes the body into ``request``. Raises RequestError."""
        payload = self._query.payload
        self.request = unpack(self._kind, payload.to_bytes() if payload is not None else _NO_FIELDS)
        return self.request

    def reply(self, body):
        with self._query as query:
            query.reply(query.key_expr, pack(body))

    def refuse(self, message, field=""):
        with self._query as query:
            query.reply_err(pack(Refusal(message, field)))


class Inbox:
    """Requests that arrive on several keys, answered by whoever calls ``serve``: one thread, no locks."""

    def __init__(self, session, wake=None):
        """``wake``: called (fast!) when a request arrives."""
        self._session, self._wake = session, wake
        self._queue = queue.SimpleQueue()
        self._queryables = []

    def on(self, key, kind, handler):
        """Requests of ``kind`` on ``key`` go to ``handler(request, exchange)``.

        What it returns is the reply; None means that it will answer ``exchange`` itself, later.
        A RequestError that it raises is sent to the asker.
        """

        def take(query):
            self._queue.put((Exchange(query, kind), handler))
            if self._wake is not None:
                self._wake()

        callback = zenoh.handlers.Callback(take, indirect=False)
        self._queryables.append(self._session.declare_queryable(key, callback, complete=True))

    def serve(self, timeout=0.0):
        """Answers what has arrived; waits up to ``timeout`` seconds for the first request."""
        try:
            item = self._queue.get(timeout=timeout) if timeout > 0 else self._queue.get_nowait()
            while True:
                self._answer(*item)
                item = self._queue.get_nowait()
        except queue.Empty:
            return

    def _answer(self, exchange, handler):
        try:
            body = handler(exchange.validate(), exchange)
        except RequestError as error:
            exchange.refuse(str(error), error.field)
        except Exception as error:  # a fault of ours: tell the asker and the log, and go on
            log.exception("a request of kind %s failed", type(exchange.request).__name__)
            exchange.refuse(f"internal error: {error}")
        else:
            if body is not None:
                exchange.reply(body)
