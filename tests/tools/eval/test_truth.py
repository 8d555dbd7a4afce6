"""Each part that is told the truth knows it, and the rest of the robot works with it."""

import numpy as np
import pytest

from edge.missions.mission import Mission
from edge.missions.motion import turn
from edge.perception.prompts import Target
from edge.pose import between
from models.manifest import DEFAULT
from tools.eval.child import in_child
from tools.eval.episode import ask
from tools.eval.oracle import OracleEncoder
from tools.eval.tour import map_home, run
from tools.eval.truth import TRUTHS, TrueDetector, TrueViewpoint, finder


class Turn(Mission):
    """A turn on the spot."""

    def story(self):
        yield from turn(self.robot, 2.0)
        return "turned"


def test_the_true_pose_has_no_error(home):
    tour = map_home(home, "oracle", 0, "pose")
    assert tour.mapped.complete and tour.mapped.nodes > 15
    believed, true = [], [tour.world.truth]

    def note():
        believed.append(tour.robot.pose)
        true.append(between(tour.world.house.start, tour.world.truth))

    run(tour.world, Turn(tour.robot), note)
    # The robot has not yet heard of the step after which it is noted; the first was taken before there were notes.
    assert np.abs(np.array(believed[1:]) - true[1:-1]).max() < 1e-9


def test_the_true_encoder_is_the_oracle(home):
    assert isinstance(map_home(home, DEFAULT, 0, "encoder").robot.encoder, OracleEncoder)


def test_the_true_box_is_that_of_the_instance(tour):
    world, encoder = tour.world, tour.robot.encoder
    detector = TrueDetector(world, encoder)
    shown = {i for i in np.unique(world.picture.instances) if i >= 0}
    assert shown
    for number in shown:
        noun = world.house.objects[world.object_ids[number]].model.name.lower()
        mask = world.picture.instances == number
        found = detector.detect(encoder.encode_image(world.picture.rgb), Target.of(noun, encoder), (320, 240))
        if mask.sum() >= OracleEncoder.MIN_PIXELS:
            rows, columns = np.nonzero(mask)
            assert found.box == (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1) and found.score == 1
        else:
            assert found is None
    assert detector.detect(encoder.encode_image(world.picture.rgb), Target.of("submarine", encoder), (320, 240)) is None


def test_the_true_viewpoint_shows_the_object(tour):
    told = Told(tour, "planner")
    mission = finder(told, Target.of("teddy bear", tour.robot.encoder), False, 0)
    assert isinstance(mission, TrueViewpoint)
    (best,) = mission.recall()
    place = between(tour.world.house.start, tour.world.house.objects["teddy-1"].pose)[:2]
    offset = place - best.pose[:2]
    assert 1 < np.hypot(*offset) < 4 and best.pose[2] == pytest.approx(np.arctan2(offset[1], offset[0]))


class Told:
    """A tour whose robot is told the truth from now on."""

    def __init__(self, tour, truth):
        self.world, self.robot, self.in_view, self.truth = tour.world, tour.robot, tour.in_view, truth


@pytest.mark.parametrize("truth", ["detector", "planner"])
def test_what_is_there_is_found_and_what_is_not_is_not(tour, truth):
    found = in_child(ask, Told(tour, truth), "vlpg-nav", "teddy bear", "", False, 0)
    assert found.success and found.truth == truth
    assert in_child(ask, Told(tour, truth), "vlpg-nav", "submarine", "", False, 0).status == "not in memory"


def test_every_truth_is_tested():
    assert set(TRUTHS) == {"pose", "encoder", "detector", "planner"}
