"""With the training extra installed only; without it, the golden file stands in for these."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("efficientnet_lite_pytorch")

from tools.train.golden import autograd_cam  # noqa: E402
from tools.train.image_tower import DEEP, DETAIL, Head, Saliency, pool  # noqa: E402


@pytest.fixture
def head():
    torch.manual_seed(0)
    return Head(torch.nn.Linear(DEEP, 50), torch.nn.functional.normalize(torch.randn(50, 24), dim=1), 0.4)


def test_closed_form_saliency_is_autograds(head):
    generator = torch.Generator().manual_seed(1)
    for _ in range(5):
        deep = torch.rand(1, DEEP, 5, 6, generator=generator) ** 4 * 6
        detail = torch.rand(1, DETAIL, 10, 12, generator=generator) ** 4 * 6
        direction = torch.randn(24, generator=generator)
        expected = autograd_cam(head, deep, detail, direction)
        found = Saliency(head)(deep, detail, direction).detach()
        assert expected.max() > 0
        np.testing.assert_allclose(found, expected, atol=1e-4 * float(expected.max()), rtol=0)


def test_sensitivity_is_autograds(head):
    pooled, direction = torch.rand(3, DEEP + DETAIL, requires_grad=True), torch.randn(3, 24)
    (head(pooled) * direction).sum().backward()
    torch.testing.assert_close(head.sensitivity(pooled, direction), pooled.grad, atol=1e-6, rtol=1e-4)


def test_the_head_gives_unit_vectors(head):
    norms = head(torch.rand(7, DEEP + DETAIL)).norm(dim=1)
    np.testing.assert_allclose(norms.detach(), 1, atol=1e-6)


@pytest.mark.parametrize(("share", "branch"), [(0.0, 0), (1.0, 1)])
def test_a_share_of_none_or_all_is_one_branch_alone(head, share, branch):
    head.share = share
    pooled = torch.rand(3, DEEP + DETAIL)
    alone = torch.nn.functional.normalize(head.branches(pooled)[branch], dim=-1)
    torch.testing.assert_close(head(pooled), alone)


def test_pooling_averages_over_columns():
    deep, detail = torch.arange(2 * 3 * 2 * 6.0).reshape(2, 3, 2, 6), torch.rand(2, 2, 4, 12)
    whole, left, right = pool(deep, detail, [(0, 1), (0, 1 / 3), (0.5, 1)]).unbind(1)
    torch.testing.assert_close(whole, torch.cat([deep.mean((2, 3)), detail.mean((2, 3))], 1))
    torch.testing.assert_close(left, torch.cat([deep[..., :2].mean((2, 3)), detail[..., :4].mean((2, 3))], 1))
    torch.testing.assert_close(right, torch.cat([deep[..., 3:].mean((2, 3)), detail[..., 6:].mean((2, 3))], 1))
