"""Every method of [V] Sec. IV answers the same question in a home where the answer is plain."""

import numpy as np
import pytest

from edge.perception.prompts import Target
from tools.eval.child import in_child
from tools.eval.episode import ask
from tools.eval.methods import METHODS, ViewpointOnly, mission_for
from tools.eval.tour import run


@pytest.mark.parametrize("method", sorted(METHODS.keys() - {"viewpoint"}))
def test_a_teddy_in_the_next_room_is_found(tour, method):
    before = tour.world.truth, tour.world.time
    episode = in_child(ask, tour, method, "teddy bear", "", False, 0)
    assert episode.success and episode.status == "found" and episode.toured and episode.cause == ""
    assert 1 < episode.duration < 60 and episode.pose_error < 0.15 and episode.distance < 15
    if method in ("viewpoint+centring", "vlpg-nav"):
        assert episode.angular_error < np.radians(6) and episode.pixel_error < 30
    assert (tour.world.truth == before[0]).all() and tour.world.time == before[1]


def test_the_viewpoint_is_where_the_memory_saw_it(tour):
    mission = mission_for("viewpoint", tour, Target.of("teddy bear", tour.robot.encoder), False, 0)
    assert isinstance(mission, ViewpointOnly)
    best = in_child(_hypotheses, tour, mission)[0].pose
    episode = in_child(ask, tour, "viewpoint", "teddy bear", "", False, 0)
    assert episode.status == "found" and np.isnan(episode.score)
    assert np.hypot(*(best - tour.robot.pose)[:2]) == pytest.approx(episode.distance, abs=0.3)


def _hypotheses(tour, mission):
    run(tour.world, mission)
    return mission.outcome.hypotheses


def test_only_the_whole_method_doubts(tour):
    asked = {method: in_child(ask, tour, method, "submarine", "", False, 0) for method in ("viewpoint", "vlpg-nav")}
    assert asked["viewpoint"].status == "found" and asked["viewpoint"].cause == "claims another thing"
    assert asked["vlpg-nav"].status == "not in memory" and asked["vlpg-nav"].success
