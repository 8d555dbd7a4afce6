import threading
import time

import pytest

from edge.link.exchange import Inbox, NoAnswer, ask
from edge.link.requests import Cancel, CancelReply, Find, RequestError, Status, pack


@pytest.fixture
def served(sessions):
    """``served(kind, handler)`` serves it on ``r/it`` in a thread, and returns the session to ask with."""
    stop, threads = threading.Event(), []

    def serve(kind, handler):
        inbox = Inbox(sessions[0])
        inbox.on("r/it", kind, handler)

        def work():
            while not stop.is_set():
                inbox.serve(timeout=0.05)

        threads.append(threading.Thread(target=work))
        threads[-1].start()
        return sessions[1]

    yield serve
    stop.set()
    for thread in threads:
        thread.join()


def test_a_request_is_answered(served):
    session = served(Cancel, lambda request, exchange: CancelReply(True))
    assert ask(session, "r/it", Cancel(), CancelReply, 5) == CancelReply(True)


def test_no_body_is_a_body_with_defaults(served):
    session = served(Cancel, lambda request, exchange: CancelReply(request == Cancel()))
    assert [reply.ok.payload.to_bytes() for reply in session.get("r/it")] == [pack(CancelReply(True))]


def test_a_refusal_reaches_the_asker_with_its_field(served):
    def handler(request, exchange):
        raise RequestError("never heard of it", "object")

    session = served(Find, handler)
    with pytest.raises(RequestError, match="never heard of it") as caught:
        ask(session, "r/it", Find("x"), CancelReply, 5)
    assert caught.value.field == "object"


def test_a_bad_body_is_refused_by_name_and_the_server_lives(served):
    session = served(Find, lambda request, exchange: CancelReply(True))
    for reply in session.get("r/it", payload=b"\xc1"):
        assert b"MessagePack" in reply.err.payload.to_bytes()
    with pytest.raises(RequestError, match="object"):
        ask(session, "r/it", Status(), CancelReply, 5)
    assert ask(session, "r/it", Find("x"), CancelReply, 5) == CancelReply(True)


def test_our_own_fault_is_logged_and_told(served, caplog):
    session = served(Cancel, lambda request, exchange: 1 / 0)
    with pytest.raises(RequestError, match="internal error: division"):
        ask(session, "r/it", Cancel(), CancelReply, 5)
    assert "Cancel failed" in caplog.text


def test_an_answer_may_come_later_and_from_another_thread(served):
    def handler(request, exchange):
        threading.Timer(0.2, exchange.reply, [CancelReply(False)]).start()

    session = served(Cancel, handler)
    started = time.monotonic()
    assert ask(session, "r/it", Cancel(), CancelReply, 5) == CancelReply(False)
    assert time.monotonic() - started >= 0.2


def test_nobody_there(sessions):
    with pytest.raises(NoAnswer, match="nobody serves r/nobody"):
        ask(sessions[1], "r/nobody", Cancel(), CancelReply, 0.5)


def test_nobody_in_time(served):
    kept = []
    session = served(Cancel, lambda request, exchange: kept.append(exchange))
    with pytest.raises(NoAnswer, match="within 0.2 s"):
        ask(session, "r/it", Cancel(), CancelReply, 0.2)
