import os
import signal
import subprocess
import sys
import time

from edge.link.alive import Watch, declare_alive


def test_tokens_come_and_go(sessions):
    watch = Watch(sessions[0], "robot1/alive/*")
    assert watch.alive == frozenset()
    token = declare_alive(sessions[1], "robot1/alive/edge")
    assert watch.wait(lambda alive: alive == {"robot1/alive/edge"}, 5)
    token.undeclare()
    assert watch.wait(lambda alive: not alive, 5)
    assert not watch.wait(bool, 0.01)


def test_those_who_lived_before_are_known(sessions):
    token = declare_alive(sessions[1], "host/alive/a")
    time.sleep(0.1)
    assert Watch(sessions[0], "host/alive/*").wait(bool, 5)
    token.undeclare()


def test_a_killed_process_is_noticed_within_a_second(sessions, endpoint):
    script = f"""
import time
from edge.link.alive import declare_alive
from edge.link.session import LinkConfig, open_session
session = open_session(LinkConfig(connect=({endpoint!r},), multicast_scouting=False))
token = declare_alive(session, "robot1/alive/base")
time.sleep(60)
"""
    watch = Watch(sessions[0], "robot1/alive/*")
    process = subprocess.Popen([sys.executable, "-c", script])
    try:
        assert watch.wait(bool, 20)
        os.kill(process.pid, signal.SIGKILL)
        assert watch.wait(lambda alive: not alive, 1.0)
    finally:
        process.kill()
        process.wait()
