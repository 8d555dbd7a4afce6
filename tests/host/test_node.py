"""The host over zenoh, with a stand-in for the text tower; then a real process."""

import os
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from edge.link.alive import Watch
from edge.link.exchange import NoAnswer, ask
from edge.link.requests import EmbedText, EmbedTextReply, RequestError, Search, SearchReply
from edge.link.session import LinkConfig, open_session
from host.node import Node

MANIFEST = SimpleNamespace(name="tower", digest="abc", dim=2, logit_scale=1.0)


def eventually(session, *arguments):
    """``ask``, again while the other side's queryables are not known yet."""
    deadline = time.monotonic() + 10
    while True:
        try:
            return ask(session, *arguments)
        except NoAnswer:
            assert time.monotonic() < deadline
            time.sleep(0.02)


def test_it_serves_and_lives_until_stopped(sessions):
    tower = SimpleNamespace(encode=lambda texts: np.tile(np.float32([0.6, 0.8]), (len(texts), 1)))
    node, stop = Node(sessions[0], tower, MANIFEST, "desk"), threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    watch = Watch(sessions[1], "host/alive/*")
    try:
        assert watch.wait(lambda alive: alive == {"host/alive/desk"}, 5)
        request = EmbedText(["a", "b"], "abc")
        reply = eventually(sessions[1], "host/embed_text", request, EmbedTextReply, 5)
        np.testing.assert_array_equal(reply.vectors.numpy(), np.float32([[0.6, 0.8], [0.6, 0.8]]))
        with pytest.raises(RequestError, match="no copy"):
            ask(sessions[1], "host/search", Search("cup", robot="nobody"), SearchReply, 5)
    finally:
        stop.set()
        thread.join(5)
    assert watch.wait(lambda alive: not alive, 5)


@pytest.mark.timeout(90)
def test_as_a_process_of_its_own(endpoint):
    """The shipped text tower answers over the wire with unit vectors, and SIGTERM ends the process cleanly."""
    from models.manifest import Manifest, resolve

    manifest = Manifest.load(resolve())
    environment = os.environ | {"ORT_DISABLE_TELEMETRY": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "host.node", "--listen", endpoint, "--no-multicast-scouting", "--id", "desk"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment)
    try:
        link = LinkConfig(connect=(endpoint,), multicast_scouting=False)
        with open_session(link, threading.Event()) as session:
            request = EmbedText(["a photo of a cup", "a photo of a mug", "a photo of a bathtub"], manifest.digest)
            vectors = eventually(session, "host/embed_text", request, EmbedTextReply, 5).vectors.numpy()
            assert vectors.shape == (3, manifest.dim)
            np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0, atol=1e-3)
            assert vectors[0] @ vectors[1] > vectors[0] @ vectors[2]
        process.send_signal(signal.SIGTERM)
        assert process.wait(10) == 0 and process.stderr.read() == ""
    finally:
        process.kill()
        process.communicate()


def test_a_model_that_is_not_there_is_one_clear_sentence(endpoint):
    command = [sys.executable, "-m", "host.node", "--listen", endpoint, "--no-multicast-scouting", "--model", "nowhere"]
    process = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=60)
    assert process.returncode == 2 and "nowhere" in process.stderr and "Traceback" not in process.stderr
