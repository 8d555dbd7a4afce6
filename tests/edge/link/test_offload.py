import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from edge.link.alive import declare_alive
from edge.link.exchange import Inbox
from edge.link.offload import OffloadConfig, OffloadedEncoder
from edge.link.requests import Array, EmbedText, EmbedTextReply, RequestError

IMAGES = SimpleNamespace(name="tower", digest="abc", dim=2, logit_scale=7.0)
HOST, OWN = np.array([[1.0, 0.0]], np.float32), np.array([[0.0, 1.0]], np.float32)


class Tower:
    """Counts how often it is asked."""

    def __init__(self):
        self.asked = 0

    def encode(self, texts):
        self.asked += 1
        return np.repeat(OWN, len(texts), 0)


@pytest.fixture
def tower():
    return Tower()


@pytest.fixture
def host(sessions):
    """``host(handler)`` starts one that answers with ``handler(request)``; returns how to make it disappear."""
    stop, started, tokens = threading.Event(), [], []

    def start(handler):
        inbox = Inbox(sessions[0])
        inbox.on("host/embed_text", EmbedText, lambda request, exchange: handler(request))
        tokens.append(declare_alive(sessions[0], "host/alive/test"))

        def work():
            while not stop.is_set():
                inbox.serve(timeout=0.05)

        thread = threading.Thread(target=work)
        thread.start()
        started.append(thread)
        return tokens[-1].undeclare

    yield start
    stop.set()
    for thread in started:
        thread.join()


def encoder(sessions, mode, tower, timeout=2.0, prompts=None):
    return OffloadedEncoder(sessions[1], IMAGES, mode, tower, prompts, OffloadConfig(timeout, patience=60.0))


def until_alive(offloaded):
    assert offloaded._watch.wait(bool, 5)


def answers(request):
    assert request == EmbedText(["a cup"], "abc")
    return EmbedTextReply(Array.of(HOST))


def test_all_else_is_the_given_encoders(sessions, tower):
    offloaded = encoder(sessions, "never", tower)
    assert (offloaded.dim, offloaded.logit_scale, offloaded.mode, offloaded.host_alive) == (2, 7.0, "never", False)
    with pytest.raises(AttributeError):
        offloaded.nonsense  # noqa: B018


@pytest.mark.parametrize("mode", ["host", "auto"])
def test_a_host_that_lives_is_asked_and_no_tower_is_used(sessions, tower, host, mode):
    host(answers)
    offloaded = encoder(sessions, mode, tower)
    until_alive(offloaded)
    np.testing.assert_array_equal(offloaded.encode_text(["a cup"]), HOST)
    assert tower.asked == 0


def test_never_asks_nobody_and_each_prompt_once(sessions, tower, host):
    host(answers)
    offloaded = encoder(sessions, "never", tower)
    for _ in range(2):
        np.testing.assert_array_equal(offloaded.encode_text(["a cup"]), OWN)
    assert tower.asked == 1


def test_what_a_host_once_said_is_known_without_it(sessions, tower, host, tmp_path):
    leave = host(answers)
    offloaded = encoder(sessions, "host", tower, prompts=tmp_path / "prompts.db")
    until_alive(offloaded)
    offloaded.encode_text(["a cup"])
    leave()
    assert offloaded._watch.wait(lambda alive: not alive, 5)
    after_restart = encoder(sessions, "host", tower, prompts=tmp_path / "prompts.db")
    np.testing.assert_array_equal(after_restart.encode_text(["a cup"]), HOST)
    with pytest.raises(RequestError, match="no host"):
        after_restart.encode_text(["a mug"])


def test_without_a_host_auto_goes_on_alone_and_host_says_what_to_do(sessions, tower):
    np.testing.assert_array_equal(encoder(sessions, "auto", tower).encode_text(["a cup"]), OWN)
    with pytest.raises(RequestError, match="vlpg host.*--offload auto"):
        encoder(sessions, "host", tower).encode_text(["a cup"])


def test_a_slow_host_is_waited_for_once(sessions, tower, host):
    host(lambda request: time.sleep(0.5) or answers(request))
    offloaded = encoder(sessions, "auto", tower, timeout=0.1)
    until_alive(offloaded)
    np.testing.assert_array_equal(offloaded.encode_text(["a cup"]), OWN)
    started = time.monotonic()
    offloaded.encode_text(["a mug"])
    assert time.monotonic() - started < 0.05


def test_a_host_that_dies_is_not_waited_for(sessions, tower, host):
    leave = host(answers)
    offloaded = encoder(sessions, "auto", tower)
    until_alive(offloaded)
    leave()
    assert offloaded._watch.wait(lambda alive: not alive, 5)
    np.testing.assert_array_equal(offloaded.encode_text(["a cup"]), OWN)
    assert not offloaded.host_alive


@pytest.mark.parametrize("bad", [np.zeros((1, 3), np.float32), np.full((1, 2), np.nan, np.float32)])
def test_vectors_that_do_not_fit_are_not_used(sessions, tower, host, bad):
    host(lambda request: EmbedTextReply(Array.of(bad)))
    offloaded = encoder(sessions, "auto", tower)
    until_alive(offloaded)
    np.testing.assert_array_equal(offloaded.encode_text(["a cup"]), OWN)
    strict = encoder(sessions, "host", tower)
    until_alive(strict)
    with pytest.raises(RequestError, match="shape"):
        strict.encode_text(["a cup"])
