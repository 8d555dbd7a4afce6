"""Ask a host which poses the whole graph agrees on, and move the map along."""

import numpy as np

from edge.link.exchange import NoAnswer, ask
from edge.link.requests import Array, Optimize, OptimizeReply, RequestError
from edge.robot import Robot

TIMEOUT = 5.0  # s; a host takes 0.2 s for 1 000 nodes


def straighten(session, robot: Robot, timeout: float = TIMEOUT) -> float:
    """Optimise the robot's graph on a host and correct the robot; the largest correction [m], 0 without a loop.

    The robot must stand still: it answers nothing meanwhile.

    Raises:
        RequestError: no host answered, or the graph cannot be optimised; nothing was changed.
    """
    edges = robot.memory.edges()
    if "loop" not in edges.kinds:
        return 0.0
    ends = np.column_stack([edges.i, edges.j])
    ids = np.unique(ends)
    before = robot.memory.poses(ids)
    request = Optimize(*(Array.of(array) for array in (ids, before, ends, edges.transforms, edges.information)))
    try:
        reply = ask(session, "host/optimize", request, OptimizeReply, timeout)
    except NoAnswer as error:
        raise RequestError(f"no host optimised the graph within {timeout:g} s; the map stays as it is") from error
    poses, covariances = reply.poses.numpy(), reply.covariances.numpy()
    if poses.shape != before.shape or covariances.shape != (len(ids), 3, 3) or not np.isfinite(poses).all():
        raise RequestError(f"the host sent poses of shape {poses.shape}; the map stays as it is")
    robot.correct(ids, poses, covariances)
    return float(np.hypot(*(poses - before)[:, :2].T).max())
