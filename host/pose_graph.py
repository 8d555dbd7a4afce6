"""Pose-graph optimisation: the poses of all nodes that agree best with what was measured between them."""

import numpy as np

from edge.pose import rotation

ANCHOR = 1e-4  # m and rad, standard deviation of the first node: the map stays where it is
# Huber's threshold, in standard deviations of the whole error (three numbers): a false loop closure pulls no harder
# than that. At 2.8, where 5 % of the true ones lie beyond, one false closure did more harm than all true ones did good.
DOUBTFUL = 1.345


class GraphError(ValueError):
    """A graph that cannot be optimised."""


def optimise(ids, poses, edges, transforms, information, trusted) -> tuple[np.ndarray, np.ndarray]:
    """Maximum a posteriori poses ``(N, 3)`` and their covariances ``(N, 3, 3)``, both in the map frame.

    ``ids (N,)`` and ``poses (N, 3)`` are the nodes as they are now, ``edges (E, 2)`` pairs of ids, ``transforms
    (E, 3)`` the pose of the second seen from the first, ``information (E, 3, 3)`` in the frame of the first. Of
    ``trusted (E,)`` edges the square of the error counts; the others may be plain wrong, like loop closures, and are
    under a robust loss. Levenberg-Marquardt by GTSAM (Dellaert 2012). The node of the least id keeps its pose.

    Raises:
        GraphError: shapes that do not fit, an edge to a node that is not there, or a graph in several pieces.
    """
    import gtsam  # late: 60 MB that only a host which optimises needs

    ids, edges = np.asarray(ids, int), np.asarray(edges, int).reshape(-1, 2)
    poses, transforms = np.asarray(poses, float), np.asarray(transforms, float)
    information, trusted = np.asarray(information, float), np.asarray(trusted, bool)
    shapes = poses.shape, transforms.shape, information.shape, trusted.shape
    if shapes != ((len(ids), 3), (len(edges), 3), (len(edges), 3, 3), (len(edges),)):
        raise GraphError(
            f"{len(ids)} nodes and {len(edges)} edges do not fit poses {poses.shape}, transforms {transforms.shape}, "
            f"information {information.shape} and trusted {trusted.shape}"
        )
    if not np.isin(edges, ids).all():
        raise GraphError("an edge leads to a node that is not in the graph")
    if not len(ids):
        return np.zeros((0, 3)), np.zeros((0, 3, 3))
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for node, pose in zip(ids, poses):
        values.insert(int(node), gtsam.Pose2(*pose))
    first = int(ids.min())
    held = gtsam.noiseModel.Isotropic.Sigma(3, ANCHOR)
    graph.add(gtsam.PriorFactorPose2(first, values.atPose2(first), held))
    for (i, j), transform, known, sure in zip(edges, transforms, information, trusted):
        noise = gtsam.noiseModel.Gaussian.Information(_in_second(known, transform[2]))
        if not sure:
            noise = gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.Huber.Create(DOUBTFUL), noise)
        graph.add(gtsam.BetweenFactorPose2(int(i), int(j), gtsam.Pose2(*transform), noise))
    try:
        values = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
        marginals = gtsam.Marginals(graph, values)
    except RuntimeError as error:  # GTSAM's name for a system without a unique solution
        raise GraphError("the graph is in several pieces, or lacks what ties a node to the others") from error
    found = [values.atPose2(int(node)) for node in ids]
    corrected = np.array([[pose.x(), pose.y(), pose.theta()] for pose in found])
    local = np.array([marginals.marginalCovariance(int(node)) for node in ids])
    return corrected, _turned(local, corrected[:, 2])


def _in_second(information: np.ndarray, turned: float) -> np.ndarray:
    """Information (3, 3) in the frame of an edge's first node, in that of the second, where GTSAM takes the error."""
    turn = rotation(turned)
    return turn.T @ information @ turn


def _turned(covariances: np.ndarray, headings: np.ndarray) -> np.ndarray:
    """Covariances in each node's own frame, as GTSAM gives them, in the map frame."""
    turn = rotation(headings)
    return turn @ covariances @ turn.transpose(0, 2, 1)
