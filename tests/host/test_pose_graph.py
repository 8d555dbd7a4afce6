"""Against SciPy's least squares on the same graph, and against the truth of a made-up drive."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from edge.pose import between, compose, wrap
from host.pose_graph import ANCHOR, GraphError, optimise

pytest.importorskip("gtsam")


@pytest.fixture(scope="module")
def drive():
    """Twice around a square of 16 nodes with noisy steps; closures tie the second lap to the first."""
    rng = np.random.default_rng(3)
    step = [np.array([1.0, 0.0, np.pi / 2 if i % 4 == 3 else 0.0]) for i in range(31)]
    truth = [np.zeros(3)]
    for move in step:
        truth.append(compose(truth[-1], move))
    truth = np.array(truth)
    sigma = np.array([0.03, 0.03, 0.02])
    measured = np.array(step) + rng.normal(0, sigma, (31, 3))
    raw = [np.zeros(3)]
    for move in measured:
        raw.append(compose(raw[-1], move))
    loops = np.array([[i, i + 16] for i in range(16)])
    closures = between(truth[:16], truth[16:]) + rng.normal(0, 0.01, (16, 3))
    edges = np.concatenate([np.stack([np.arange(31), np.arange(1, 32)], 1), loops])
    information = np.concatenate([np.repeat(np.diag(sigma**-2)[None], 31, 0), np.repeat(np.eye(3)[None] * 1e4, 16, 0)])
    return truth, np.array(raw), edges, np.concatenate([measured, closures]), information


def driven(edges):
    return np.diff(edges)[:, 0] == 1


def rms(poses, truth):
    return np.sqrt((np.hypot(*(poses - truth)[:, :2].T) ** 2).mean())


def test_closures_bring_the_nodes_nearer_to_the_truth(drive):
    truth, raw, edges, transforms, information = drive
    poses, covariances = optimise(np.arange(32), raw, edges, transforms, information, driven(edges))
    assert rms(poses, truth) < 0.6 * rms(raw, truth)
    np.testing.assert_allclose(poses[0], 0, atol=1e-3)
    assert (np.linalg.eigvalsh(covariances) > 0).all()


def test_agrees_with_least_squares(drive):
    _, raw, edges, transforms, information = drive
    odometry = slice(0, 31)  # without loops no loss is robust, and with one closure added both must find the same
    edges = np.concatenate([edges[odometry], edges[-1:]])
    transforms = np.concatenate([transforms[odometry], transforms[-1:]])
    information = np.concatenate([information[odometry], information[-1:] * 1e-5])  # so weak that it is no outlier
    poses, _ = optimise(np.arange(32), raw, edges, transforms, information, driven(edges))
    roots = np.linalg.cholesky(information).transpose(0, 2, 1)

    def residuals(flat):
        x = flat.reshape(-1, 3)
        error = between(transforms, between(x[edges[:, 0]], x[edges[:, 1]]))
        return np.concatenate([x[0] / ANCHOR, (roots @ error[..., None]).ravel()])

    expected = least_squares(residuals, raw.ravel(), x_scale="jac").x.reshape(-1, 3)
    np.testing.assert_allclose(poses[:, :2], expected[:, :2], atol=2e-3)
    assert np.abs(wrap(poses[:, 2] - expected[:, 2])).max() < 1e-3


def test_what_is_known_well_is_kept_and_what_is_not_gives_way():
    """Two readings of one step around a corner, each sure of one axis of the first node's frame."""
    sure_of_x, sure_of_y = np.diag([1e6, 1.0, 1e6]), np.diag([1.0, 1e6, 1e6])
    transforms = [[1.0, 0.5, np.pi / 2], [1.2, 0.4, np.pi / 2]]
    poses, covariances = optimise(
        [0, 1], [[0, 0, 0], [1, 0.5, np.pi / 2]], [[0, 1], [0, 1]], transforms, [sure_of_x, sure_of_y], [True, True]
    )
    np.testing.assert_allclose(poses[1], [1.0, 0.4, np.pi / 2], atol=1e-3)


def test_one_false_closure_does_little_harm(drive):
    truth, raw, edges, transforms, information = drive
    edges = np.concatenate([edges, [[2, 25]]])
    false = np.concatenate([transforms, [[4.0, 3.0, 1.0]]]), np.concatenate([information, information[-1:]])
    poses, _ = optimise(np.arange(32), raw, edges, *false, driven(edges))
    assert rms(poses, truth) < rms(raw, truth)


@pytest.mark.parametrize(
    ("edges", "words"), [([[0, 7]], "not in the graph"), ([[0, 1], [0, 1]], "do not fit"), ([[1, 2]], "pieces")]
)
def test_a_graph_that_cannot_be_solved_is_told_in_a_sentence(edges, words):
    with pytest.raises(GraphError, match=words):
        optimise([0, 1, 2], np.zeros((3, 3)), edges, np.zeros((1, 3)), np.eye(3)[None], [True])


def test_an_empty_graph_stays_empty():
    poses, covariances = optimise([], np.zeros((0, 3)), [], np.zeros((0, 3)), np.zeros((0, 3, 3)), [])
    assert poses.shape == (0, 3) and covariances.shape == (0, 3, 3)
