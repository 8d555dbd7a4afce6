"""The host process: serves `host/embed_text`, `host/search` and `host/optimize` over zenoh."""

import argparse
import logging
import uuid

from edge.link.alive import declare_alive
from edge.link.exchange import Inbox, ask
from edge.link.requests import EmbedText, GraphReply, Optimize, Search
from edge.link.session import LinkError, ToldToStop, add_link_arguments, key_root, link_config, open_session
from edge.memory.prompts import PromptMemory
from edge.process import cache_file, stop_event
from host.service import HostService
from models.manifest import Manifest, ModelError, resolve

# s for a robot to send what is new in its memory. It answers between two control steps; if it waits itself for this
# host, it does so for a second.
FETCH_TIMEOUT = 0.7


class Node:
    """Answers requests, one after another, in the thread that calls ``run``."""

    def __init__(self, session, tower, manifest, identity):
        """``identity``: of this host among several; its liveliness token is ``host/alive/<identity>``."""
        self.service = HostService(
            tower, manifest, lambda robot, body: ask(session, f"{robot}/graph", body, GraphReply, FETCH_TIMEOUT)
        )
        self._inbox = Inbox(session)
        self._inbox.on("host/embed_text", EmbedText, lambda request, exchange: self.service.embed_text(request))
        self._inbox.on("host/search", Search, lambda request, exchange: self.service.search(request))
        self._inbox.on("host/optimize", Optimize, lambda request, exchange: self.service.optimize(request))
        self._alive = declare_alive(session, f"host/alive/{identity}")

    def run(self, stop):
        """Serves until the Event ``stop`` is set."""
        while not stop.is_set():
            self._inbox.serve(timeout=0.2)
        self._alive.undeclare()


def main(arguments=None):
    """``python -m host.node``: serves until SIGTERM or Ctrl-C."""
    parser = argparse.ArgumentParser(prog="vlpg host", description="Take work off robots.")
    parser.add_argument("--model", help="name or folder of the encoder (default: the shipped one)")
    parser.add_argument(
        "--id", type=_identity, default=uuid.uuid4().hex[:8], help="name of this host (default: a random one)"
    )
    add_link_arguments(parser)
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")

    from edge.perception.text import TextTower

    stop = stop_event()
    try:
        manifest = Manifest.load(resolve(options.model) if options.model else resolve())
        manifest.verify()
        with open_session(link_config(options), stop) as session:
            tower = TextTower(manifest)
            tower.open()  # its robots wait one second for an answer
            prompts = PromptMemory(tower.encode, manifest.digest, manifest.dim, cache_file("prompts.db"))
            Node(session, prompts, manifest, options.id).run(stop)
    except ToldToStop:
        pass
    except (LinkError, ModelError) as error:
        parser.exit(2, f"vlpg host: {error}\n")


def _identity(text):
    if "/" in text:
        raise argparse.ArgumentTypeError(f"{text!r} has a slash in it; take one word")
    return key_root(text)


if __name__ == "__main__":
    main()
