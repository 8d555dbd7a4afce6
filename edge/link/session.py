"""Opening a zenoh session with the flags of zenoh's own examples and the settings a small robot needs."""

import argparse
import json
import logging
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import zenoh

from edge.link.requests import KEY

log = logging.getLogger(__name__)

RETRY = 0.5  # s between attempts to connect
LEASE = 2000  # ms without a sign of life before a peer counts as gone; zenoh's default of 10 s is long for a robot


class LinkError(RuntimeError):
    """A session that cannot be opened; the message says what to do."""


class ToldToStop(LinkError):
    """Nobody listened until the process was told to stop, which is no mistake."""


def key_root(text):
    """A robot's name, for argparse: a key of zenoh, as ``robot1`` or ``lab/robot1``.

    Not one with an ``@``, which zenoh's wildcards leave out, or in the hosts' own name space.
    """
    first, *_ = parts = text.split("/")
    if not re.fullmatch(KEY, text) or first == "host" or any(part.startswith("@") for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} is no name; take letters and digits, such as robot1, and not host")
    return text


@dataclass(frozen=True)
class LinkConfig:
    """How to find the others. Without any, peers find one another by multicast, as zenoh does."""

    connect: tuple[str, ...] = ()  # endpoints such as tcp/192.168.1.5:7447
    listen: tuple[str, ...] = ()  # endpoints; a peer with neither listen nor scouting listens nowhere
    mode: Literal["peer", "client", "router"] | None = None  # default: the file's, or what suits the endpoints
    config: Path | None = None  # a zenoh JSON5 file; the other fields take precedence
    multicast_scouting: bool = True  # False also stops gossip: only the stated endpoints are used

    def to_zenoh(self):
        """The ``zenoh.Config``. Raises LinkError for a file or a value that zenoh does not accept."""
        try:
            config = zenoh.Config() if self.config is None else zenoh.Config.from_file(str(self.config))
        except zenoh.ZError as error:
            raise LinkError(f"{self.config} is not a zenoh configuration: {_reason(error)}") from error
        settings = {
            "transport/shared_memory/enabled": False,  # costs 45 MB a process, and would flatter network figures
            "transport/link/tx/lease": LEASE,
            "connect/retry": {"period_init_ms": 250, "period_max_ms": 1000, "period_increase_factor": 2},
        }
        mode = self.mode
        if mode is None and self.config is None and not self.multicast_scouting:
            # Who may not look for the others meets them through the one that listens, and it must route for them.
            mode = "router" if self.listen else "client"
        if mode:
            settings["mode"] = mode
        if self.connect:
            settings["connect/endpoints"] = list(self.connect)
        if self.listen or not self.multicast_scouting:
            settings["listen/endpoints"] = list(self.listen)
        if not self.multicast_scouting:
            settings["scouting/multicast/enabled"] = settings["scouting/gossip/enabled"] = False
            settings["scouting/delay"] = 0  # ms; nothing to wait for
        for key, value in settings.items():
            try:
                config.insert_json5(key, json.dumps(value))
            except zenoh.ZError as error:
                raise LinkError(f"zenoh does not accept {value!r} for {key}: {_reason(error)}") from error
        return config


def add_link_arguments(parser: argparse.ArgumentParser):
    """Adds the flags of zenoh's examples to ``parser``, in full; ``link_config`` reads them."""
    parser.allow_abbrev = False  # the vlpg command, which adds them where there are none, knows no others
    many = {"action": "append", "default": [], "metavar": "ENDPOINT"}
    parser.add_argument("--connect", "-e", help="endpoint to connect to, e.g. tcp/192.168.1.5:7447", **many)
    parser.add_argument("--listen", "-l", help="endpoint to listen on, e.g. tcp/0.0.0.0:7447", **many)
    parser.add_argument("--mode", "-m", choices=["peer", "client", "router"], help="zenoh session mode")
    parser.add_argument("--config", "-c", type=Path, metavar="FILE", help="zenoh configuration file (JSON5)")
    parser.add_argument("--no-multicast-scouting", action="store_true", help="use the stated endpoints only")


def link_config(arguments: argparse.Namespace):
    """The LinkConfig of parsed arguments."""
    return LinkConfig(
        tuple(arguments.connect),
        tuple(arguments.listen),
        arguments.mode,
        arguments.config,
        not arguments.no_multicast_scouting,
    )


def open_session(link: LinkConfig, stop=None, waiting=lambda: None):
    """A ``zenoh.Session``; close it, or use it as a context manager.

    With ``stop``, an Event, a client waits for the other side to come up, until the event is set; meanwhile it calls
    ``waiting`` now and then.

    Raises LinkError when an endpoint is malformed or busy, or a client finds no one to connect to; ToldToStop when the
    event was set before it did.
    """
    config, told = link.to_zenoh(), False
    while True:
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            alone = "Unable to connect" in str(error)
            if not alone or stop is None:
                raise LinkError(_explain(link, str(error))) from error
            if stop.is_set():
                raise ToldToStop(_explain(link, str(error))) from error
        if not told:
            log.info("waiting for somebody to listen at %s", " ".join(link.connect))
            told = True
        waiting()
        stop.wait(RETRY)


def _explain(link, text):
    listens, connects = " ".join(link.listen), " ".join(link.connect)
    if "Address already in use" in text:
        return f"{listens} is already in use by another program; stop it, or choose another port with --listen"
    if "Cannot assign requested address" in text:
        return f"{listens} is not an address of this machine; choose another with --listen"
    if connects and ("Unable to connect" in text or "refused" in text):
        return f"nobody answers at {connects}; start the other side first, or correct --connect"
    return f"cannot open the zenoh session (listen {listens or '-'}, connect {connects or '-'}): {_reason(text)}"


def _reason(error):
    """What zenoh says, without the places in its source code."""
    return re.sub(r"[\s.]*\bat /\S+\.rs:\d+\.?", "", str(error)).splitlines()[0].strip()
