"""Ask a host which poses the whole graph agrees on, and move the map along."""

from typing import TYPE_CHECKING

import numpy as np

from edge.link.exchange import NoAnswer, ask
from edge.link.requests import Array, Optimize, OptimizeReply, RequestError
from edge.localization.loop_closure import bent

if TYPE_CHECKING:  # the link knows the robot by its parts
    from edge.robot import Robot

TIMEOUT = 5.0  # s; a host takes 0.2 s for 1 000 nodes


def straighten(session, robot: "Robot", timeout: float = TIMEOUT) -> tuple[np.ndarray, np.ndarray]:
    """Optimise the robot's graph on a host and correct the robot; the nodes' poses (N, 3) before and after.

    While most loop closures agree with the poses as they are, nobody is asked, and N is 0. The robot must stand still:
    it answers nothing meanwhile.

    Raises:
        RequestError: no host answered, or the graph cannot be optimised; nothing was changed.
    """
    if not bent(robot.memory):
        return np.zeros((0, 3)), np.zeros((0, 3))
    edges = robot.memory.edges()
    ends = np.column_stack([edges.i, edges.j])
    ids = np.unique(ends)
    before = robot.memory.poses(ids)
    parts = ids, before, ends, edges.transforms, edges.information, edges.trusted
    request = Optimize(*(Array.of(array) for array in parts))
    try:
        reply = ask(session, "host/optimize", request, OptimizeReply, timeout)
    except NoAnswer as error:
        raise RequestError(f"no host optimised the graph within {timeout:g} s; the map stays as it is") from error
    poses, covariances = reply.poses.numpy(), reply.covariances.numpy()
    finite = np.isfinite(poses).all() and np.isfinite(covariances).all()
    if poses.shape != before.shape or covariances.shape != (len(ids), 3, 3) or not finite:
        raise RequestError(f"the host sent poses of shape {poses.shape}; the map stays as it is")
    try:
        robot.correct(ids, poses, covariances)
    except ValueError as error:
        raise RequestError(f"what the host sent does not fit ({error}); the map stays as it is") from error
    return before, poses
