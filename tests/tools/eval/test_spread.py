"""Which kept results count for an evaluation that goes on."""

import json
import time
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from models.manifest import Manifest, resolve
from tools.eval import spread
from tools.eval.objectnav.campaign import Plan
from tools.eval.objectnav.planners import PLANNERS


@dataclass(frozen=True)
class Found:
    home: str


class Search:
    """In the apartment it fails, and the cottage takes longer than that."""

    encoder = "oracle"

    def run(self, home):
        if home == "apartment":
            raise RuntimeError("the apartment is on fire")
        time.sleep(2.0 if home == "cottage" else 0.0)
        return Found(home)

    def read(self, raw):
        return Found(**raw)

    def columns(self):
        return []

    def __repr__(self):
        return "search"


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


def test_a_home_that_fails_takes_nothing_of_the_others(tmp_path):
    homes = ["cottage", "apartment"]
    with pytest.raises(RuntimeError, match="on fire"):
        list(spread.run_homes(homes, Search(), 2, tmp_path))
    (kept,) = tmp_path.glob("*.json")
    assert spread.load(kept, Search()) == Found("cottage")


def test_results_of_other_code_are_told(tmp_path):
    told = []
    assert list(spread.run_homes(["bungalow"], Search(), 1, tmp_path, tell=told.append)) == [Found("bungalow")]
    assert list(spread.run_homes(["bungalow"], Search(), 1, tmp_path, tell=told.append)) == [Found("bungalow")]
    assert not told
    (kept,) = tmp_path.glob("*.json")
    kept.write_text(json.dumps(json.loads(kept.read_text()) | {"code": "0" * 12}))
    assert list(spread.run_homes(["bungalow"], Search(), 1, tmp_path, tell=told.append)) == [Found("bungalow")]
    assert "1 of 1 homes" in told[0] and "other code" in told[0]
