"""Is what the robot says true? Asked of the simulator, in one sentence."""

from dataclasses import dataclass
from math import isnan

from firmware_sim.house import House
from tools.demo.naming import named
from tools.eval.judge import judge
from tools.report.record import Verdict


@dataclass(frozen=True, slots=True)
class Judgement:
    """What is true where the robot stopped."""

    verdict: Verdict
    remark: str  # one sentence
    angular_error: float | None  # rad; None without anything of that name
    visible: float  # share of the best instance's silhouette that the camera sees
    true_positions: list[tuple[float, float]]


def judgement(world, words: str, claimed: bool) -> Judgement:
    """Judge an answer about ``words`` at the robot's present place.

    ``world`` needs ``truth``, ``house``, ``config.camera_model`` and ``visible_fraction``, as a World has them.
    """
    things = named(world.house, words)
    places = [(thing.x, thing.y) for thing in things]
    if not things:
        remark = f"Nothing in this home is called {words}."
        return Judgement("wrong" if claimed else "no claim", remark, None, 0.0, places)
    verdicts = [judge(world, name) for name in {thing.model.name for thing in things}]
    best = min(verdicts, key=lambda verdict: (not verdict.in_view, verdict.angular_error))
    visible = world.visible_fraction(best.object_id)
    error = None if isnan(best.angular_error) else best.angular_error
    seen = f"{_article(world.house, best.object_id)} ({best.object_id})"
    if best.in_view:
        remark = f"{seen} is in view, {visible:.0%} of it visible."
    elif visible > 0:
        remark = f"{seen} is hardly in view, {visible:.0%} of it visible."
    else:
        remark = f"{seen} is not in view."
    verdict = ("confirmed" if best.in_view else "wrong") if claimed else "no claim"
    return Judgement(verdict, remark, error, visible, places)


def _article(house: House, object_id: str) -> str:
    return f"The {house.objects[object_id].model.name.lower()}"
