import argparse
import json
import threading
import time

import pytest

from edge.link.session import LinkConfig, LinkError, ToldToStop, add_link_arguments, key_root, link_config, open_session

ALONE = {"multicast_scouting": False}


def setting(link, key):
    return json.loads(link.to_zenoh().get_json(key))


def test_the_flags_of_zenohs_examples():
    parser = argparse.ArgumentParser()
    add_link_arguments(parser)
    flags = ["-e", "tcp/a:1", "--connect", "tcp/b:2", "-l", "tcp/c:3", "-m", "client", "--no-multicast-scouting"]
    expected = LinkConfig(("tcp/a:1", "tcp/b:2"), ("tcp/c:3",), "client", None, False)
    assert link_config(parser.parse_args(flags)) == expected
    assert link_config(parser.parse_args([])) == LinkConfig()


@pytest.mark.parametrize("name", ["robot1", "lab/robot1"])
def test_a_name_is_a_key(name):
    assert key_root(name) == name


@pytest.mark.parametrize("name", ["", "/robot1", "robot1/", "*", "robot 1", "a//b", "host", "host/a", "@a", "a/@b"])
def test_what_is_no_key_is_no_name(name):
    with pytest.raises(argparse.ArgumentTypeError, match="is no name"):
        key_root(name)


def test_loopback_means_loopback():
    link = LinkConfig(connect=("tcp/127.0.0.1:7",), **ALONE)
    assert setting(link, "scouting/multicast/enabled") is False
    assert setting(link, "scouting/gossip/enabled") is False
    assert setting(link, "listen/endpoints") == []
    assert setting(link, "transport/shared_memory/enabled") is False


@pytest.mark.parametrize(
    "link, mode",
    [
        (LinkConfig(listen=("tcp/127.0.0.1:7",), **ALONE), "router"),
        (LinkConfig(connect=("tcp/127.0.0.1:7",), **ALONE), "client"),
        (LinkConfig(listen=("tcp/127.0.0.1:7",), mode="peer", **ALONE), "peer"),
        (LinkConfig(listen=("tcp/127.0.0.1:7",)), None),
    ],
)
def test_who_alone_listens_routes_for_the_others(link, mode):
    assert setting(link, "mode") == mode


def test_a_config_file_is_the_base_and_flags_go_first(tmp_path):
    path = tmp_path / "zenoh.json5"
    path.write_text('{mode: "client", connect: {endpoints: ["tcp/1.2.3.4:5"]}}')
    assert setting(LinkConfig(config=path), "mode") == "client"
    assert setting(LinkConfig(config=path), "connect/endpoints") == ["tcp/1.2.3.4:5"]
    assert setting(LinkConfig(config=path, mode="peer"), "mode") == "peer"


def test_a_busy_port_is_one_clear_sentence(endpoint):
    link = LinkConfig(listen=(endpoint,), **ALONE)
    with open_session(link), pytest.raises(LinkError, match=f"{endpoint} is already in use.*--listen") as caught:
        open_session(link)
    assert "\n" not in str(caught.value) and ".rs" not in str(caught.value)


@pytest.mark.parametrize(
    "link, said",
    [
        (LinkConfig(connect=("tcp/127.0.0.1:1",), mode="client", **ALONE), "nobody answers at tcp/127.0.0.1:1"),
        (LinkConfig(listen=("tcp/192.0.2.1:7447",), **ALONE), "not an address of this machine"),
        (LinkConfig(listen=("nonsense",), **ALONE), "does not accept"),
    ],
)
def test_what_cannot_be_opened_is_explained(link, said):
    with pytest.raises(LinkError, match=said) as caught:
        open_session(link)
    assert ".rs" not in str(caught.value)


def test_a_config_file_that_is_none(tmp_path):
    with pytest.raises(LinkError, match="not a zenoh configuration"):
        open_session(LinkConfig(config=tmp_path / "none.json5"))


def test_two_that_only_connect_meet_through_the_one_that_listens(sessions, endpoint):
    link = LinkConfig(connect=(endpoint,), **ALONE)
    with open_session(link) as third:
        queryable = third.declare_queryable("r/it", lambda query: query.reply("r/it", b"yes"))
        deadline = time.monotonic() + 5
        replies = []
        while not replies and time.monotonic() < deadline:
            replies = [reply.ok.payload.to_bytes() for reply in sessions[1].get("r/it", timeout=1)]
        assert replies == [b"yes"]
        queryable.undeclare()


def test_a_client_can_wait_for_the_other_side(endpoint):
    opened = []

    def open_late():
        time.sleep(0.3)
        opened.append(open_session(LinkConfig(listen=(endpoint,), **ALONE)))

    thread = threading.Thread(target=open_late)
    thread.start()
    waited = []
    with open_session(LinkConfig(connect=(endpoint,), **ALONE), threading.Event(), lambda: waited.append(True)):
        thread.join()
    assert waited
    opened[0].close()


def test_a_client_that_waits_can_be_stopped(endpoint):
    stop = threading.Event()
    threading.Timer(0.1, stop.set).start()
    with pytest.raises(ToldToStop, match="nobody answers"):
        open_session(LinkConfig(connect=(endpoint,), **ALONE), stop)
