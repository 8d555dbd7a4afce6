"""Which kept results count for an evaluation that goes on."""

from dataclasses import replace
from pathlib import Path

import pytest

from models.manifest import Manifest, resolve
from tools.eval import spread
from tools.eval.objectnav.campaign import Plan
from tools.eval.objectnav.planners import PLANNERS

PLAN = Plan((("closest", PLANNERS["closest"]),), "lite0-minilm")


@pytest.fixture
def name(monkeypatch):
    """The name of a result's file, by the home, the plan and a manifest that was changed."""
    shipped = Manifest.load(resolve())

    def of(home="apartment", plan=PLAN, **changes):
        monkeypatch.setattr(spread.Manifest, "load", lambda folder: replace(shipped, **changes))
        return spread._file(home, plan)

    return of


def test_whatever_changes_what_an_encoder_says_makes_other_results(name):
    shipped = Manifest.load(resolve())
    same = name(folder=Path("elsewhere"), measured={"image_time": 1.0})
    steeper = replace(shipped.relevance, slope=2 * shipped.relevance.slope)
    others = [name(logit_scale=1.0), name(relevance=steeper), name(digest="0" * 64), name("cottage")]
    others += [name(plan=replace(PLAN, settings="another release's")), name(plan=replace(PLAN, seed=1))]
    others += [name(plan=replace(PLAN, encoder="oracle"))]
    assert name() == same and len({same, *others}) == 1 + len(others)
