"""What the host does for robots: encode text, search and straighten what they remember. No sockets, no clocks."""

import numpy as np

from edge.link.exchange import NoAnswer
from edge.link.requests import (
    Array,
    EmbedText,
    EmbedTextReply,
    Graph,
    GraphReply,
    Optimize,
    OptimizeReply,
    RequestError,
    Search,
    SearchReply,
)
from edge.perception.prompts import contrast
from host.pose_graph import GraphError, optimise
from host.replica import Replica


class HostService:
    """Answers requests with one text tower. One thread at a time."""

    def __init__(self, tower, manifest, fetch):
        """``tower.encode(texts) -> (N, D)``; ``manifest`` has its ``digest``, ``dim`` and ``logit_scale``.

        ``fetch(robot, Graph) -> GraphReply`` asks a robot; it raises NoAnswer when the robot does not answer.
        """
        self._tower, self._manifest, self._fetch = tower, manifest, fetch
        self._replicas: dict[str, Replica] = {}

    def embed_text(self, request: EmbedText) -> EmbedTextReply:
        """Raises RequestError when the robot runs another encoder: vectors of two pairs cannot be compared."""
        if request.digest != self._manifest.digest:
            raise RequestError(
                f"the host's encoder is {self._manifest.name} ({self._manifest.digest[:12]}) and the robot's is "
                f"{request.digest[:12]}; start both with the same --model",
                "digest",
            )
        return EmbedTextReply(Array.of(np.asarray(self._tower.encode(request.texts), np.float32)))

    def optimize(self, request: Optimize) -> OptimizeReply:
        """Raises RequestError for a graph that has no unique solution."""
        arrays = (request.ids, request.poses, request.edges, request.transforms, request.information, request.trusted)
        try:
            poses, covariances = optimise(*(array.numpy() for array in arrays))
        except GraphError as error:
            raise RequestError(str(error), "edges") from error
        except ModuleNotFoundError as error:
            raise RequestError("this host lacks GTSAM; install vlpg-edge[host] there") from error
        return OptimizeReply(Array.of(poses), Array.of(covariances))

    def search(self, request: Search) -> SearchReply:
        """Brings the copy of the robot's memory up to date, or does without, and searches it ([V] Eq. 2).

        Raises RequestError when the robot runs another encoder, or was never heard of.
        """
        replica, fresh = self._follow(request.robot)
        positive, negative = self._tower.encode(list(contrast(request.object)))
        hits, poses = replica.search(positive - negative, request.k)
        scores = 1 / (1 + np.exp(-self._manifest.logit_scale * hits.scores))
        arrays = (hits.ids, scores.astype(np.float32), poses, hits.bearings)
        return SearchReply(*(Array.of(array) for array in arrays), nodes=len(replica), fresh=fresh)

    def _follow(self, robot):
        replica = self._replicas.get(robot)
        try:
            graph = self._graph(robot, 0 if replica is None else replica.next)
            if replica is not None and graph.memory != replica.memory:  # it has mapped a home anew
                graph, replica = self._graph(robot, 0), None
        except NoAnswer as error:
            if replica is None:
                raise RequestError(f"{robot} does not answer and the host has no copy of it", "robot") from error
            return replica, False
        if replica is None:
            replica = Replica(self._manifest.dim, graph.memory)
        try:
            replica.update(graph)
        except ValueError as error:
            raise RequestError(str(error), "robot") from error
        self._replicas[robot] = replica
        return replica, True

    def _graph(self, robot, first) -> GraphReply:
        """The robot's graph, with the vectors of nodes from ``first`` on."""
        graph = self._fetch(robot, Graph(vectors_from=first))
        if graph.digest != self._manifest.digest:
            raise RequestError(f"{robot} remembers with the encoder {graph.encoder}, the host has another", "robot")
        if graph.vectors is None:
            raise RequestError(f"{robot} sent no vectors; it runs another version", "robot")
        return graph
