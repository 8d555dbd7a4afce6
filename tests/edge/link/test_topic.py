import threading
import time

import pytest

from edge.link import messages
from edge.link.messages import MessageError, stamp_of
from edge.link.topic import Topic, publisher


def stamped(seconds):
    return messages.Imu(messages.Header(messages.Time.of(seconds)))


@pytest.fixture
def stream(sessions):
    """A topic that keeps 3, its publisher, and a function that waits until n samples have arrived."""
    listening, connected = sessions
    arrived = threading.Semaphore(0)
    topic = Topic(listening, "r/imu", messages.Imu, keep=3, wake=arrived.release)
    source = publisher(connected, "r/imu", command=True)

    def wait(n):
        for _ in range(n):
            assert arrived.acquire(timeout=5)

    deadline = time.monotonic() + 5
    while not source._publisher.matching_status.matching and time.monotonic() < deadline:
        time.sleep(0.01)
    return topic, source, wait


def test_nothing_yet(sessions):
    topic = Topic(sessions[0], "r/imu", messages.Imu)
    assert topic.read_latest() is None and topic.take() == [] and topic.age == float("inf")


def test_only_the_newest_is_kept(stream):
    topic, source, wait = stream
    for n in range(10):
        source.put(stamped(n))
    wait(10)
    assert topic.read_latest().header.stamp.sec == 9
    assert topic.read_latest() is topic.read_latest()  # decoded once
    assert [stamp_of(payload) for payload in topic.take()] == [7, 8, 9]
    assert topic.take() == [] and topic.read_latest() is None
    assert topic.age < 5


def test_another_type_on_the_key_is_an_error_for_the_reader_only(stream, sessions):
    topic, _, wait = stream
    sessions[1].put("r/imu", b"not an imu")
    wait(1)
    with pytest.raises(MessageError, match="Imu"):
        topic.read_latest()
