"""Replies about what the robot knows: its map, its graph, how a search ended."""

import numpy as np

from edge.jpeg import jpeg
from edge.link.conversions import JPEG_QUALITY
from edge.link.requests import (
    Array,
    FindReply,
    GraphReply,
    Hypothesis,
    MapReply,
    Replan,
    TourReply,
    Vectors,
)


def areas(robot):
    """Free floor [m2] that is known, and how much of it the camera has looked at."""
    cell = robot.grid.frame.resolution**2
    free, viewed = robot.grid.free, robot.coverage.viewed
    seen = np.count_nonzero(free & viewed.view(bool)) if viewed.shape == free.shape else 0
    return float(np.count_nonzero(free) * cell), float(seen * cell)


def map_reply(grid, path):
    """``path``: (x, y) [m] where the robot drove."""
    cells = np.full(grid.frame.shape, -1, np.int8)
    cells[grid.free] = 0
    cells[grid.occupied] = 100
    origin = (float(grid.frame.origin[0]), float(grid.frame.origin[1]))
    return MapReply(Array.of(cells), origin, grid.frame.resolution, Array.of(np.reshape(path, (-1, 2)).astype("f4")))


def graph_reply(memory, encoder, vectors_from):
    """The nodes that answer queries, all edges between them, and the vectors from node ``vectors_from`` on, if any."""
    ids, edges = memory.ids, memory.edges()
    kept = np.isin(edges.i, ids) & np.isin(edges.j, ids)
    vectors = None
    if vectors_from is not None:
        rows = memory.export()
        new = rows[0] >= vectors_from
        vectors = Vectors(*(Array.of(array[new]) for array in rows))
    return GraphReply(
        Array.of(ids),
        Array.of(memory.poses(ids)),
        Array.of(np.column_stack([edges.i, edges.j])[kept]),
        encoder.name,
        encoder.digest,
        f"{memory.id}.{memory.opening}",
        vectors,
    )


def find_reply(name, outcome, robot, frame):
    """``outcome`` of a FindObject mission for the object ``name``; ``frame``: the last picture, or None."""
    seen = outcome.claim and outcome.claim.sighting
    return FindReply(
        status=outcome.status,
        object=name,
        pose=_pose(robot.pose),
        duration=outcome.duration,
        distance=outcome.distance,
        hypotheses=[
            Hypothesis(_pose(h.pose), h.score, [_pose(outcome.places[member]) for member in h.members])
            for h in outcome.hypotheses
        ],
        position=seen and (float(seen.position[0]), float(seen.position[1])),
        bearing=seen and float(seen.bearing),
        depth=seen and float(seen.depth),
        score=seen and float(seen.detection.score),
        box=seen and tuple(float(value) for value in seen.detection.box),
        jpeg=_picture(frame),
        confidence=outcome.confidence,
        replans=[_replan(replan) for replan in outcome.replans],
    )


def cancelled_reply(name, robot, frame, duration, distance):
    """A search that was broken off."""
    return FindReply("cancelled", name, _pose(robot.pose), duration, distance, [], jpeg=_picture(frame))


def tour_reply(outcome, robot):
    """``outcome`` of a MapHome mission."""
    status = "complete" if outcome.complete else "lost" if robot.localizer.lost else "timeout"
    return TourReply(status, outcome.duration, outcome.distance, len(robot.memory))


def _replan(replan):
    cells = np.rint(255 * replan.probability).astype(np.uint8)
    x, y = (float(value) for value in replan.frame.origin)
    return Replan(Array.of(cells), (x, y), replan.frame.resolution, _pose(replan.pose))


def _pose(pose):
    return tuple(float(value) for value in pose)


def _picture(frame):
    return None if frame is None else jpeg(frame.rgb, JPEG_QUALITY)
