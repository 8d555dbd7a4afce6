"""With the training extra installed only."""

import pytest

torch = pytest.importorskip("torch")

from tools.train import losses  # noqa: E402


def test_naming_falls_when_positives_rise_and_negatives_sink():
    positive = torch.tensor([[True, False, False], [False, True, False]])
    negative = torch.tensor([[False, True, True], [True, False, False]])
    good = torch.where(positive, 3.0, -3.0)
    assert losses.naming(good, positive, negative) < losses.naming(torch.zeros(2, 3), positive, negative)
    # What is neither named nor denied does not matter.
    other = good.clone()
    other[1, 2] = 50.0
    torch.testing.assert_close(losses.naming(other, positive, negative), losses.naming(good, positive, negative))


def test_pointing_is_least_where_the_object_is():
    presence = torch.zeros(1, 4, 6)
    presence[0, 1:3, 2:4] = 1
    elsewhere = presence.roll(2, dims=2)
    wide = presence + 0.7 * elsewhere
    at = [float(losses.pointing(saliency - 0.1, presence)) for saliency in (presence, wide, elsewhere)]
    assert at[0] < at[1] < at[2]


def test_pointing_is_finite_at_an_object_that_fills_the_picture_and_at_a_flat_map():
    everywhere = torch.ones(2, 4, 6)
    maps = torch.stack([torch.zeros(4, 6), torch.rand(4, 6)]).requires_grad_()
    loss = losses.pointing(maps, everywhere)
    loss.backward()
    assert torch.isfinite(loss) and torch.isfinite(maps.grad).all()


def test_nothing_is_forgotten_while_the_posteriors_are_the_same():
    before = torch.randn(2, 4, 10, generator=torch.Generator().manual_seed(0))
    assert float(losses.forgetting(before + 3.0, before)) == pytest.approx(0, abs=1e-5)
    assert float(losses.forgetting(before.flip(2), before)) > 0.1
