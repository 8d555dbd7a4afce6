"""``python -m tools.bench.search KIND COUNT``: nearest-neighbour search over so many vectors, as a probe.

The same unit vectors of 512 components and the same queries for all; the peers with the defaults that their users meet,
but one thread.
"""

import sys
from collections.abc import Callable

import numpy as np

from edge.bench.store import DIM, HITS, filled, unit_vectors
from tools.models.probe import serve

REGIONS = 4  # vectors a node
QUERIES = 64


def vlpg(count: int) -> Callable[[np.ndarray], object]:
    memory = filled(":memory:", count // REGIONS, REGIONS)
    return lambda query: memory.search(query, HITS)


def numpy(count: int) -> Callable[[np.ndarray], object]:
    matrix = unit_vectors(count, 0)

    def search(query):
        scores = matrix @ query
        best = np.argpartition(-scores, HITS)[:HITS]
        best = best[np.argsort(-scores[best])]
        return best, scores[best]

    return search


def faiss(count: int) -> Callable[[np.ndarray], object]:
    import faiss

    faiss.omp_set_num_threads(1)
    index = faiss.IndexFlatIP(DIM)
    index.add(unit_vectors(count, 0))
    return lambda query: index.search(query[None], HITS)


def usearch(count: int) -> Callable[[np.ndarray], object]:
    from usearch.index import Index

    index = Index(ndim=DIM, metric="ip", dtype="i8")
    index.add(np.arange(count), unit_vectors(count, 0), threads=1)
    return lambda query: index.search(query, HITS, exact=True, threads=1)


def usearch_graph(count: int) -> Callable[[np.ndarray], object]:
    from usearch.index import Index

    index = Index(ndim=DIM, metric="ip", dtype="i8")
    index.add(np.arange(count), unit_vectors(count, 0), threads=1)
    return lambda query: index.search(query, HITS, threads=1)


KINDS = {"vlpg": vlpg, "numpy": numpy, "faiss": faiss, "usearch": usearch, "usearch-graph": usearch_graph}


def main() -> None:
    kind, count = sys.argv[1:]
    search, queries = KINDS[kind](int(count)), unit_vectors(QUERIES, 1)
    serve(lambda i: search(queries[i % QUERIES]))


if __name__ == "__main__":
    main()
